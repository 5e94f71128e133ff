// The doublet of a nearly straight wire, ever nearer to each other, with one reference (shaken along y), two
// (y, z) and three (y, z, x): resolved within its error bars, reported as one and flagged, or silently wrong?
// Rows: spacing in half-power bandwidths; fields: shares [%] of the three, rms error of what is resolved in
// standard errors, mean standard error of the frequency in bandwidths. Noise 1 % of each
// output's largest value. Advice: a second direction tells what no finer line and no less noise can.
// Argument: seeds, 40 if none.

#include <fmt/format.h>

#include <cstdlib>

#include "tests/ident/simulated_references.hpp"

int main(int count, char** words) {
  using namespace struna::ident::simulated;
  const unsigned seeds = count > 1 ? static_cast<unsigned>(std::atoi(words[1])) : 40;
  fmt::print("resolved/flagged/neither [%], rms error/sigma, sigma of f/bandwidth\n{:>10}", "spacing");
  for (int references = 1; references <= 3; ++references) fmt::print("{:>30}", references);
  fmt::print("\n");
  for (const double spacing : {0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0}) {
    const BowedWire bowed = bowed_for(spacing);
    fmt::print("{:>10.3f}", bowed.spacing);
    for (int references = 1; references <= 3; ++references) {
      const ReferenceVerdicts v = reference_verdicts(bowed, references, 0.01, seeds);
      const double squares = std::max(1.0, static_cast<double>(v.squares));
      fmt::print("{:>30}", fmt::format("{}/{}/{}  {:.2f}  {:.4f}", 100 * v.resolved / seeds,
                                       100 * v.flagged / seeds, 100 * v.wrong / seeds,
                                       std::sqrt(v.square_sum / squares), 2.0 * v.frequency_sigma / squares));
    }
    fmt::print("\n");
  }
}
