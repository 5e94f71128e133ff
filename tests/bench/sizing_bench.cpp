// Does the choice of a model keep its tolerance, and at what cost? sizing_bench [LINEAR [CONTACT [FIRST]]],
// by default 200 random linear scenes and 40 with contact in time, seeds from FIRST (1) on.
//
// Linear: natural frequencies and response on the mesh chosen, against a reference of two and a half times
// the elements, whose own error is shown; the cheapest mesh is found by bisection. Contact: displacements of
// the contact points up to 20 ms beyond the first touch on the modes and steps chosen, against a run with
// every mode at a twentieth of the tolerance on the same mesh; apart from it, what twice the elements (the
// same contact points) would change. Cost is steps times modes, the cheapest setting the cheapest of a grid
// that meets the tolerance.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/fem/rattling_scene.hpp"
#include "tests/fem/sized_scene.hpp"

namespace {

using namespace struna::fem;
using namespace struna::fem::testing;

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

class Tally {
 public:
  explicit Tally(const char* what) : what_(what) {}
  void add(unsigned seed, double error, double cost, double reference_error) {
    errors_.push_back(error);
    costs_.push_back(cost);
    references_.push_back(reference_error);
    if (error > 1.0 || cost > 2.0)
      fmt::print("  {} seed {}: error/tolerance {:.2f}, cost {:.2f}\n", what_, seed, error, cost);
  }
  void print() const {
    const auto count = [](const std::vector<double>& values, double limit) {
      return std::count_if(values.begin(), values.end(), [&](double value) { return value <= limit; });
    };
    const double all = static_cast<double>(errors_.size());
    fmt::print("{:<22}{:>7}{:>10.1f} %{:>10.2f}{:>10.2f}{:>10.1f} %{:>10.2f}{:>10.2f}{:>12.3f}\n", what_,
               errors_.size(), 100.0 * static_cast<double>(count(errors_, 1.0)) / all, quantile(errors_, 0.5),
               quantile(errors_, 1.0), 100.0 * static_cast<double>(count(costs_, 2.0)) / all,
               quantile(costs_, 0.5), quantile(costs_, 1.0), quantile(references_, 1.0));
  }

 private:
  const char* what_;
  std::vector<double> errors_, costs_, references_;
};

}  // namespace

int main(int argc, char** argv) {
  const auto argument = [&](int i, int fallback) { return argc > i ? std::atoi(argv[i]) : fallback; };
  const auto first = static_cast<unsigned>(argument(3, 1));
  Tally frequencies("natural frequencies"), responses("response"), contact("contact in time");
  std::vector<double> mesh;
  int checks = 0;
  for (unsigned seed = first; seed < first + static_cast<unsigned>(argument(1, 200)); ++seed) {
    const SizedScene sized = size_scene(random_scene(seed));
    const auto add = [&](Tally& tally, const SizedOutcome& outcome) {
      tally.add(seed, outcome.error, static_cast<double>(outcome.elements) / outcome.fewest,
                outcome.reference_error);
    };
    add(frequencies, sized.frequency);
    add(responses, sized.response);
    checks += sized.response.checks;
    std::fflush(stdout);
  }
  for (unsigned seed = first; seed < first + static_cast<unsigned>(argument(2, 40)); ++seed) {
    const SizedRun run = size_run(random_rattling_scene(seed));
    contact.add(seed, run.error, run.cost, run.reference_error);
    mesh.push_back(run.mesh_error);
    std::fflush(stdout);
  }
  fmt::print("{:<22}{:>7}{:>12}{:>10}{:>10}{:>12}{:>10}{:>10}{:>12}\n", "", "scenes", "within", "median",
             "worst", "cost <= 2", "median", "worst", "reference");
  frequencies.print();
  responses.print();
  if (!mesh.empty()) {
    contact.print();
    fmt::print(
        "with contact, twice the elements change paths by {:.2f} of the tolerance (median), {:.1f} (worst)\n",
        quantile(mesh, 0.5), quantile(mesh, 1.0));
  }
  fmt::print("responses solved again after the check on a finer mesh: {}\n", checks);
  return 0;
}
