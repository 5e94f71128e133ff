#include "apps/curve_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "fem/curve_shape.hpp"
#include "fem/error.hpp"

namespace struna::apps {
namespace {

using Points = std::vector<Eigen::Vector3d>;

std::string statement_of(const fem::CurveError& error, const std::string& name, std::size_t points) {
  if (error.digitised)
    return fmt::format(
        "body '{}': curve through {} points that scatter by {:.2g} m: natural frequencies within {:.2g} %",
        name, points, error.scatter, 100.0 * error.worst);
  return fmt::format(
      "body '{}': curve drawn by {} points: natural frequencies {:.2g} % from those of tight bends at them",
      name, points, 100.0 * error.worst);
}

/// Natural frequencies that the points leave open; fills error and statement.
void check_error(const fem::Body& body, const Points& points, double length, CurveReport& report) {
  try {
    report.error = fem::curve_error(body, points, length);
  } catch (const Error& fault) {
    report.warnings.push_back(
        fmt::format("of body '{}' do not tell how the curve runs: {}", body.name, fault.reason()));
    return;
  }
  const fem::CurveError& error = report.error;
  if (error.sigma.size() == 0) return;
  report.statement = statement_of(error, body.name, points.size());
  if (!(error.probability > likely)) return;
  const std::string why = error.scatter > 0.0
                              ? fmt::format("they scatter by some {:.2g} m, {:.2g} m apart", error.scatter,
                                            body.centreline.length() / static_cast<double>(points.size() - 1))
                              : "a bend lies between them";
  report.warnings.push_back(
      fmt::format("of body '{}' leave open how the curve runs: {}, and natural frequencies are off by some "
                  "{:.2g} %; give more and truer points",
                  body.name, why, 100.0 * error.worst));
}

/// A curve drawn by few points has its bends between them.
void check_few(const fem::Body& body, const Points& points, CurveReport& report) {
  if (body.centreline.is_straight() || points.size() >= fem::fewest_digitised) return;
  const std::vector<double> turn = fem::turns(points);
  const auto sharpest = std::max_element(turn.begin(), turn.end());
  const std::string off = fmt::format(
      "natural frequencies are {:.2g} % from those of a tight bend; give points "
      "along the bend",
      100.0 * report.error.worst);
  if (*sharpest > sharpest_turn) {
    report.warnings.push_back(fmt::format(
        "of body '{}' turn by {:.2g} rad at point {} alone, and the curve is rounded over its neighbours: {}",
        body.name, *sharpest, sharpest - turn.begin() + 2, off));
  } else if (const int straight = fem::straight_beside_bend(points); straight > 0) {
    report.warnings.push_back(
        fmt::format("of body '{}' run straight on at point {} beside a bend, which the curve does not: {}",
                    body.name, straight + 1, off));
  }
}

}  // namespace

CurveReport report_curve(const fem::Body& body, const Points& points, double length) {
  CurveReport report;
  check_error(body, points, length, report);
  check_few(body, points, report);
  const bool open = report.error.probability > likely || !report.error.digitised;
  if (const int i = fem::stray_pair(points); i >= 0 && open) {
    const auto first = static_cast<std::size_t>(i);
    report.warnings.push_back(fmt::format(
        "of body '{}' turn the curve aside where points {} and {} are too near each other, {:.2g} m apart: "
        "take one of them out",
        body.name, i + 1, i + 2, (points[first + 1] - points[first]).norm()));
  }
  // A zigzag of points is no bend where the curve behind them has none.
  const double drawn = fem::smallest_radius(body.centreline), thick = fem::thickness(body.section);
  const double radius = open ? drawn : std::max(drawn, report.error.radius);
  if (radius < tightest_bend * thick)
    report.warnings.push_back(fmt::format(
        "of body '{}' bend it to a radius of {:.2g} m, {:.2g} times its thickness: below {:g} times beam "
        "theory does not hold; is there a kink, or are points in the wrong order?",
        body.name, radius, radius / thick, tightest_bend));
  return report;
}

}  // namespace struna::apps
