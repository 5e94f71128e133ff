// Two modes of equal height and width ever nearer to each other: resolved within their error bars, flagged,
// or silently wrong? A chart in characters: rows spacing in half-power bandwidths, columns outputs and noise
// (of the peak), each field the shares [%] of resolved, flagged and unflagged others over 20 noises. The
// program ends with 1 where any is silently wrong. Advice: further outputs tell nearer modes apart than less
// noise does.

#include <fmt/format.h>

#include "tests/ident/simulated_doublet.hpp"

int main() {
  using namespace struna::ident::simulated;
  constexpr unsigned seeds = 20;
  fmt::print("resolved/flagged/neither [%]\n{:>10}", "spacing");
  for (const int outputs : {1, 3})
    for (const double noise : {0.001, 0.01, 0.05})
      fmt::print("{:>18}", fmt::format("{} out, {:g} %", outputs, 100.0 * noise));
  fmt::print("\n");
  bool wrong = false;
  for (const double spacing : {0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0}) {
    fmt::print("{:>10g}", spacing);
    for (const int outputs : {1, 3})
      for (const double noise : {0.001, 0.01, 0.05}) {
        const Verdicts v = doublet_verdicts({spacing, outputs, noise}, seeds);
        fmt::print("{:>18}", fmt::format("{}/{}/{}", 100 * v.resolved / seeds, 100 * v.flagged / seeds,
                                         100 * v.wrong / seeds));
        wrong = wrong || v.wrong > 0;
      }
    fmt::print("\n");
  }
  return wrong ? 1 : 0;
}
