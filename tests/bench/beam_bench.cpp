// Times of the beam model on the spline wire of 28 elements (162 free dof), best of several runs on one
// thread, and their ratio to a purpose-built code compiled for its machine (-O3 -march=native).

#include <fmt/format.h>


#include "fem/eigenmodes.hpp"
#include "fem/harmonic.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/fem/bodies.hpp"

namespace {

using namespace struna::fem;
using struna::tests::best_seconds;

void report(const char* what, double seconds, double reference) {
  fmt::print("{:<28}{:>12.2f}{:>14.2f}{:>8.2f}\n", what, 1e6 * seconds, 1e6 * reference, seconds / reference);
}

}  // namespace

int main() {
  constexpr int elements = 28;
  constexpr int lines = 400;
  const Body body = testing::spline_wire();
  const Model model = assemble(body, elements);
  const Drive drive = SupportMotion{{End::start}, Eigen::Vector3d::UnitY()};
  const Measurement measurement = {
      SupportForce{End::end}, {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}};
  const Eigen::VectorXd frequency_hz = Eigen::VectorXd::LinSpaced(lines, 10.0, 1000.0);
  double sum = 0.0;  // keeps the work from being optimised away

  fmt::print("{:<28}{:>12}{:>14}{:>8}\n", "what", "time [us]", "reference [us]", "ratio");
  report("assembly", best_seconds(500, [&] { sum += assemble(body, elements).mass.lower(0, 0); }), 15e-6);
  report("all 162 eigenpairs", best_seconds(20, [&] { sum += solve_eigenmodes(model).eigenvalue(0); }),
         3.2e-3);
  const double sweep = best_seconds(
      20, [&] { sum += harmonic_response(model, drive, measurement, frequency_hz).response(0, 0).real(); });
  report("one harmonic line of 400", sweep / lines, 26e-6);
  const Eigen::VectorXd single = Eigen::VectorXd::Constant(1, 100.0);
  report("one harmonic line alone",
         best_seconds(
             200, [&] { sum += harmonic_response(model, drive, measurement, single).response(0, 0).real(); }),
         26e-6);
  return sum == sum ? 0 : 1;
}
