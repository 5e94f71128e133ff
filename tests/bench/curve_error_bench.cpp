// Are the errors that are stated for curves through digitised points as large as the errors? Arcs and wavy
// space curves. Rows: shape, turn, points, root mean square of error over stated error (should be 1),
// largest, share beyond 2, over errors of the points of 0 to 3 mm. Argument: seeds, 10 if none. Last, the
// time that one estimate takes, in solutions of the eigenproblem of 40 elements.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>

#include "fem/curve_error.hpp"
#include "fem/eigenmodes.hpp"
#include "tests/fem/bodies.hpp"
#include "tests/fem/digitised_curves.hpp"

namespace {

using namespace struna::fem;

Eigen::ArrayXd frequencies(const Centreline& curve) {
  return solve_eigenmodes(assemble(testing::wire_along(curve), 40), curve_modes).eigenvalue.array().sqrt();
}

double seconds(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void row(int waves, double turn, int points, int seeds) {
  double square = 0.0, largest = 0.0;
  int count = 0, beyond = 0;
  for (const double error : {0.0, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3}) {
    for (unsigned seed = 1; seed <= static_cast<unsigned>(seeds); ++seed) {
      const Centreline truth = waves == 0 ? circular_arc(0.68, turn) : testing::wavy_curve(turn, waves, seed);
      const auto read = testing::digitised(truth, points, error, seed);
      const Centreline through = spline_through(read);
      const double off = (frequencies(through) / frequencies(truth) - 1.0).abs().maxCoeff();
      const double z = off / curve_error(testing::wire_along(through), read, 0.0).worst;
      square += z * z;
      largest = std::max(largest, z);
      beyond += z > 2.0;
      ++count;
    }
  }
  fmt::print("{:>8}{:>8}{:>8}{:>8.2f}{:>9.2f}{:>9.3f}\n", waves, turn, points, std::sqrt(square / count),
             largest, static_cast<double>(beyond) / count);
}

}  // namespace

int main(int count, char** words) {
  const int seeds = count > 1 ? std::atoi(words[1]) : 10;
  fmt::print("{:>8}{:>8}{:>8}{:>8}{:>9}{:>9}\n", "waves", "turn", "points", "rms", "largest", "beyond 2");
  for (const int waves : {0, 1, 2, 4})
    for (const double turn : {0.5, 1.5, 4.5})
      for (const int points : {8, 12, 16, 24, 48, 96}) row(waves, turn, points, seeds);
  for (const int points : {8, 24, 96, 960}) {
    const auto read = testing::digitised(circular_arc(0.68, 1.5), points, 1e-4, 1);
    const Body body = testing::wire_along(spline_through(read));
    frequencies(body.centreline);
    const double one = seconds([&] { frequencies(body.centreline); });
    const double all = seconds([&] { curve_error(body, read, 0.0); });
    fmt::print("{} points: {:.1f} solutions, {:.1f} ms\n", points, all / one, 1e3 * all);
  }
}
