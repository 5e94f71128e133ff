#include "apps/limit_kinks.hpp"

#include <cmath>
#include <random>

#include "apps/limit_curves.hpp"
#include "fem/curve_error.hpp"
#include "fem/rounded_polygon.hpp"

namespace struna::apps {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr double drawn = 0.0;  ///< "radius" of the panel in which the curve is what the points draw
constexpr int fine = 200;      ///< elements; twice as many move no frequency by 1e-4

fem::Centreline two_pieces(double kink, double angle, double radius) {
  const double a = kink * curve_length, b = curve_length - a;
  return fem::rounded_polygon({{0, 0, 0}, {a, 0, 0}, {a + b * std::cos(angle), b * std::sin(angle), 0}},
                              radius);
}

Points points_along(const fem::Centreline& curve, int count) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(curve.at(curve.length() * i / (count - 1)).position);
  return points;
}

}  // namespace

LimitMap kink_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "kinks";
  map.title = "Curve through points about a bend";
  map.quantity = curve_quantity;
  map.fails = "a spline rounds a bend over the points next to it and swings beyond them";
  map.sign =
      "curves that the points leave possible, the turn at each of few points and straight pieces beside it";
  map.then = "warns that the points leave the curve open, or turn too sharply";
  map.axes = {run.axis("points [-]", {3, 4, 5, 6, 7, 8, 10, 14, 20, 28, 40}),
              run.axis("angle of the bend [rad]", {0.1, 0.2, 0.4, 0.8, 1.2, 1.6, 2.4}),
              run.axis("radius of the bend [thicknesses]; 0: along the spline", {drawn, 2, 10, 50})};
  for_each_place(map.axes, [&](const std::vector<double>& at) {
    const int count = static_cast<int>(at[0]);
    for (const unsigned seed : run.draws(at[2] == drawn ? 1 : 3)) {
      std::mt19937_64 engine(seed);
      const double kink = std::uniform_real_distribution<double>(0.3, 0.7)(engine);
      LimitTrial trial;
      trial.at = at;
      trial.seed = seed;
      if (at[2] == drawn) {
        const Points points = points_along(fem::circular_arc(curve_length, at[1]), count);
        // Few points draw the curve; many were read off the arc.
        judge_curve(points,
                    count < static_cast<int>(fem::fewest_digitised)
                        ? curve_eigenvalues(fem::spline_through(points), fine)
                        : curve_eigenvalues(fem::circular_arc(curve_length, at[1]), fine),
                    trial);
      } else {
        const fem::Centreline shape = two_pieces(kink, at[1], at[2] * curve_diameter);
        judge_curve(points_along(shape, count), curve_eigenvalues(shape, fine), trial);
      }
      map.trials.push_back(std::move(trial));
    }
  });
  return map;
}

LimitMap near_point_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "near_points";
  map.title = "Curve through two points next to each other";
  map.quantity = curve_quantity;
  map.fails = "two points that are nearly one tell a direction that is only their error";
  map.sign =
      "their distance beside the chords next to them, the direction, and curves that the points leave "
      "possible";
  map.then = "warns of the two points, or refuses them where they coincide";
  map.axes = {run.axis("points [-]", {5, 7, 9, 13, 25, 49}),
              run.axis("distance [of the spacing]", {0, 1e-7, 1e-5, 1e-3, 1e-2, 0.03, 0.1, 0.3}),
              run.axis("error of the second point [mm]", {0, 0.01, 0.1, 1})};
  const fem::Centreline arc = fem::circular_arc(curve_length, 1.5);
  const Eigen::VectorXd truth = curve_eigenvalues(arc, fine);
  for_each_place(map.axes, [&](const std::vector<double>& at) {
    for (const unsigned seed : run.draws(at[2] > 0.0 ? 3 : 1)) {
      std::mt19937_64 engine(seed);
      std::normal_distribution<double> normal;
      const int count = static_cast<int>(at[0]);
      Points points = points_along(arc, count);
      const auto between = std::uniform_int_distribution<int>(1, count - 2)(engine);
      Vector3d second = arc.at(curve_length * (between + at[1]) / (count - 1)).position;
      for (double& coordinate : second) coordinate += 1e-3 * at[2] * normal(engine);
      points.insert(points.begin() + between + 1, second);
      LimitTrial trial;
      trial.at = at;
      trial.seed = seed;
      // What few points without the second one draw is the curve that is meant.
      Points without = points;
      without.erase(without.begin() + between + 1);
      const bool few = points.size() < fem::fewest_digitised;
      judge_curve(points, few ? curve_eigenvalues(fem::spline_through(without), fine) : truth, trial);
      map.trials.push_back(std::move(trial));
    }
  });
  return map;
}

}  // namespace struna::apps
