// Do the stated errors hold what they promise? Simulated measurements of a curved wire (five modes, three
// outputs), each with other noise, identified from the transfer functions on. Rows: quantity, intervals,
// share of 95 % intervals that hold the truth. Should be 0.92 to 0.98. Argument: number of experiments, 400
// if none.

#include <fmt/format.h>

#include <cstdlib>

#include "tests/ident/simulated_experiment.hpp"

int main(int count, char** words) {
  using namespace struna::ident::simulated;
  const int runs = count > 1 ? std::atoi(words[1]) : 400;
  const Experiment e = experiment();
  Coverages c;
  for (int seed = 1; seed <= runs; ++seed) add_run(e, static_cast<unsigned>(seed), c);
  fmt::print("{} experiments, {} with modes lost or added\n{:<28}{:>12}{:>12}\n", runs, c.lost_or_added,
             "quantity", "intervals", "coverage");
  const auto row = [](const char* name, const Coverage& coverage) {
    fmt::print("{:<28}{:>12}{:>12.3f}\n", name, coverage.all, coverage.share());
  };
  row("natural frequency", c.frequency);
  row("loss factor", c.loss_factor);
  row("modulus at the modes", c.modulus);
  row("modulus law", c.modulus_law);
  row("predicted magnitude", c.prediction);
}
