// Do the stated errors hold what they promise? Simulated measurements of a curved wire (five modes, three
// outputs), each with other noise: identified from the transfer functions on, and from time records on (60 s,
// the automatic estimator), the outputs' noise their own or nine tenths of it shared by all of them. Rows:
// quantity, intervals, share of 95 % intervals that hold the truth. Should be 0.92 to 0.98. Arguments: number
// of experiments, 400 if none; duration of the records in s, 60 if none.

#include <fmt/format.h>

#include <cstdlib>
#include <functional>

#include "tests/ident/simulated_experiment.hpp"

namespace {

using namespace struna::ident::simulated;

void print_coverage(const char* title, int runs, const std::function<void(unsigned, Coverages&)>& run) {
  Coverages c;
  for (int seed = 1; seed <= runs; ++seed) run(static_cast<unsigned>(seed), c);
  fmt::print("{}: {} experiments, {} with modes lost or added\n{:<28}{:>12}{:>12}\n", title, runs,
             c.lost_or_added, "quantity", "intervals", "coverage");
  const auto row = [](const char* name, const Coverage& coverage) {
    fmt::print("{:<28}{:>12}{:>12.3f}\n", name, coverage.all, coverage.share());
  };
  row("natural frequency", c.frequency);
  row("loss factor", c.loss_factor);
  row("modulus at the modes", c.modulus);
  row("modulus law", c.modulus_law);
  row("predicted magnitude", c.prediction);
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** words) {
  const int runs = count > 1 ? std::atoi(words[1]) : 400;
  const Experiment e = experiment();
  print_coverage("transfer functions", runs, [&](unsigned seed, Coverages& c) { add_run(e, seed, c); });
  const RecordedExperiment recorded = recorded_experiment(count > 2 ? std::atof(words[2]) : 60.0);
  print_coverage("records", runs,
                 [&](unsigned seed, Coverages& c) { add_recorded_run(recorded, 0.0, seed, c); });
  print_coverage("records, shared noise", runs,
                 [&](unsigned seed, Coverages& c) { add_recorded_run(recorded, 0.9, seed, c); });
}
