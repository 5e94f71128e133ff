#include "ident/joint_fit.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "fem/error.hpp"
#include "ident/elastic_modes.hpp"
#include "ident/least_squares.hpp"

namespace struna::ident {
namespace {

using Kind = fem::FrequencyLaw::Kind;

constexpr double small_compliance = 3e-3;
constexpr double least_compliance = 1e-6;  // of a spring that a frequency cannot tell from a clamp
constexpr double most_compliance = 10.0;
constexpr double most_mass = 100.0;  // of the body's own
constexpr double torsion_range = 1e3;
constexpr double worst_sigma = 0.5;      // relative; a number known worse than this is not known
constexpr double worst_inflation = 3.0;  // of a standard error by what is fitted beside it

enum class Unknown { torsion, spring, mass };

/// How a number is fitted: x = ln(value/reference), reference/value or value/reference.
struct Coordinate {
  fem::BodyNumber number;
  Unknown kind = Unknown::torsion;
  double reference = 1.0;

  double x(double value) const {
    return kind == Unknown::torsion  ? std::log(value / reference)
           : kind == Unknown::spring ? reference / value
                                     : value / reference;
  }
  double value(double at) const {
    return kind == Unknown::torsion  ? reference * std::exp(at)
           : kind == Unknown::spring ? reference / at
                                     : reference * at;
  }
  double slope(double at) const {  ///< d value/d x
    return kind == Unknown::torsion  ? value(at)
           : kind == Unknown::spring ? -reference / (at * at)
                                     : reference;
  }
  double lower() const {
    return kind == Unknown::torsion  ? -std::log(torsion_range)
           : kind == Unknown::spring ? least_compliance
                                     : 0.0;
  }
  double upper() const {
    return kind == Unknown::torsion  ? std::log(torsion_range)
           : kind == Unknown::spring ? most_compliance
                                     : most_mass;
  }
  /// Standard error of x that stands for worst_sigma of the value.
  double worst(double at) const { return kind == Unknown::torsion ? worst_sigma : worst_sigma * at; }
  /// Of the number as FittedNumbers tells it, per that of x.
  double told(double at) const {
    return kind == Unknown::torsion ? 1.0 : kind == Unknown::spring ? -1.0 / at : reference;
  }
};

Coordinate coordinate(const fem::Body& body, const std::string& name) {
  Coordinate c;
  c.number = fem::fittable_number(body, name);
  const double length = body.centreline.length();
  if (name == "torsion_constant") {
    c.reference = body.section.torsion_constant;
  } else if (name.ends_with(".mass")) {
    c.kind = Unknown::mass;
    c.reference = body.density * body.section.area * length;
  } else {
    c.kind = Unknown::spring;
    c.reference =
        body.material.youngs_modulus.at(fem::support_reference_hz) * body.section.second_moment / length;
    if (name.ends_with(".translation")) c.reference /= length * length;
  }
  return c;
}

/// What the frequencies are explained by: the law's x first, then the numbers' ones.
class Problem {
 public:
  Problem(const fem::Model& model, const fem::Eigenmodes& modes, int rigid,
          const std::vector<PairedFrequency>& pairs, Kind law, const std::vector<Coordinate>& coordinates)
      : model_(model), modes_(modes), rigid_(rigid), pairs_(pairs), coordinates_(coordinates) {
    const auto n = static_cast<Eigen::Index>(pairs.size());
    law_ = Eigen::MatrixXd::Ones(n, law == Kind::power ? 2 : 1);
    log_omega2_.resize(n);
    weight_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const PairedFrequency& pair = pairs[static_cast<std::size_t>(i)];
      log_omega2_[i] = 2.0 * std::log(2.0 * std::numbers::pi * pair.frequency_hz);
      weight_[i] = 1.0 / pair.sigma;
      if (law == Kind::power) law_(i, 1) = std::log(pair.frequency_hz);
    }
    if (law == Kind::power) law_.col(1).array() -= law_.col(1).mean();
  }

  Eigen::Index law_size() const { return law_.cols(); }

  fem::Body body_at(const Eigen::VectorXd& numbers) const {
    fem::Body body = model_.body;
    for (std::size_t k = 0; k < coordinates_.size(); ++k) {
      const Coordinate& c = coordinates_[k];
      body = fem::moved(body, c.number, c.value(numbers[static_cast<Eigen::Index>(k)]) - c.number.value);
    }
    return body;
  }

  Eigen::VectorXd residual(const Eigen::VectorXd& x) {
    evaluate(x.tail(x.size() - law_.cols()));
    return weight_.cwiseProduct(log_omega2_ - log_lambda_ - law_ * x.head(law_.cols()));
  }
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& x) {
    evaluate(x.tail(x.size() - law_.cols()));
    Eigen::MatrixXd j(law_.rows(), x.size());
    j << -law_, -slopes_;
    return weight_.asDiagonal() * j;
  }
  /// The law's share at given numbers.
  Eigen::VectorXd start(const Eigen::VectorXd& numbers) {
    evaluate(numbers);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(law_.cols() + numbers.size());
    x[0] = (log_omega2_ - log_lambda_).mean();
    x.tail(numbers.size()) = numbers;
    return x;
  }

 private:
  void evaluate(const Eigen::VectorXd& numbers) {
    if (at_.size() == numbers.size() && at_ == numbers && log_lambda_.size() > 0) return;
    at_ = numbers;
    const int elements = static_cast<int>(model_.arc_length.size()) - 1;
    const fem::Model model = fem::assemble(body_at(numbers), elements);
    const fem::Eigenmodes all =
        fem::solve_eigenmodes(model, static_cast<int>(modes_.eigenvalue.size() + rigid_));
    std::vector<PairedFrequency> followed = follow(model, all);
    const Eigen::VectorXd log_lambda = all.eigenvalue.unaryExpr(
        [&](double v) { return std::log(without_mesh_error(std::max(v, 1e-300), model)); });
    log_lambda_ = over_pairs(followed, log_lambda);
    slopes_.resize(log_lambda_.size(), numbers.size());
    for (std::size_t k = 0; k < coordinates_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      fem::BodyNumber number = coordinates_[k].number;
      number.value = coordinates_[k].value(numbers[at]);
      slopes_.col(at) = coordinates_[k].slope(numbers[at]) *
                        over_pairs(followed, fem::log_eigenvalue_slopes(model, all, number));
    }
  }

  /// The modes that a pair's own have become: as many as it has, of the largest overlap with their space.
  std::vector<PairedFrequency> follow(const fem::Model& model, const fem::Eigenmodes& all) const {
    const Eigen::MatrixXd overlap =
        (modes_.shape.transpose() * fem::multiply(model.mass, all.shape)).cwiseAbs2();
    std::vector<PairedFrequency> followed = pairs_;
    for (PairedFrequency& pair : followed) {
      const Eigen::VectorXd share = overlap(pair.mode, Eigen::all).colwise().sum();
      std::vector<int> order(static_cast<std::size_t>(share.size()));
      std::iota(order.begin(), order.end(), 0);
      std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return share[a] > share[b]; });
      order.resize(pair.mode.size());
      pair.mode = order;
    }
    return followed;
  }

  const fem::Model& model_;
  const fem::Eigenmodes& modes_;
  int rigid_;
  const std::vector<PairedFrequency>& pairs_;
  const std::vector<Coordinate>& coordinates_;
  Eigen::MatrixXd law_;
  Eigen::VectorXd log_omega2_;
  Eigen::VectorXd weight_;
  Eigen::VectorXd at_;
  Eigen::VectorXd log_lambda_;
  Eigen::MatrixXd slopes_;
};

/// Ratio of the largest to the smallest singular value, columns of unit length.
double condition_of(const Eigen::MatrixXd& jacobian) {
  const Eigen::RowVectorXd length = jacobian.colwise().norm();
  if (!(length.minCoeff() > 0.0)) return std::numeric_limits<double>::infinity();
  const Eigen::MatrixXd scaled = jacobian.array().rowwise() / length.array();
  const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
  return singular[0] / singular[singular.size() - 1];
}

/// (J^T J)^-1 at the scatter that is left when that is more than the given sigmas, columns scaled to one;
/// infinite where J lacks rank. Numbers on a bound count like the others.
Eigen::MatrixXd full_covariance(const Eigen::MatrixXd& jacobian, double rms) {
  const Eigen::Index n = jacobian.cols();
  const Eigen::VectorXd length = jacobian.colwise().norm();
  if (jacobian.rows() < n || !(condition_of(jacobian) < 1e6))
    return Eigen::MatrixXd::Constant(n, n, std::numeric_limits<double>::infinity());
  const Eigen::VectorXd inverse = length.cwiseInverse();
  const Eigen::MatrixXd scaled = jacobian * inverse.asDiagonal();
  const Eigen::MatrixXd normal = (scaled.transpose() * scaled).inverse();
  return std::pow(std::max(1.0, rms), 2) * (inverse.asDiagonal() * normal * inverse.asDiagonal());
}

struct Verdict {
  double badness = 0.0;  ///< standard error over the worst one that is let pass
  std::string reason;
};

/// Why the frequencies do not tell a number.
std::optional<Verdict> inseparable(const Coordinate& c, double x, double sigma, double sigma_alone,
                                   std::size_t pairs) {
  const double worst = c.worst(x);
  if (sigma <= worst && x > c.lower()) return std::nullopt;
  const std::string known =
      c.kind == Unknown::torsion
          ? std::string("to a factor of ") + fmt::format("{:.3g}", std::exp(sigma_alone))
          : fmt::format("to {:.3g} %", 100.0 * sigma_alone / std::max(x, least_compliance));
  const double badness = std::isfinite(sigma) ? sigma / std::max(worst, 1e-300) : 1e300;
  if (!(sigma_alone <= c.worst(std::max(x, small_compliance)))) {
    return Verdict{
        badness,
        c.kind == Unknown::torsion
            ? fmt::format("the {} paired modes hardly depend on it (with all else given it would be "
                          "known {} only): a curved body, shaken so that it twists, tells it",
                          pairs, known)
            : fmt::format("the {} paired modes hardly depend on it; more modes, higher ones, tell more",
                          pairs)};
  }
  if (!(sigma <= worst_inflation * sigma_alone)) {
    return Verdict{
        badness,
        fmt::format(
            "it moves the {} paired modes as the modulus law or another fitted number does (multiple "
            "correlation {:.4f}); a simpler law (--modulus-law constant), a modulus measured otherwise, more "
            "modes, or one number for both ends (both.rotation) separate them",
            pairs, std::sqrt(std::max(0.0, 1.0 - std::pow(sigma_alone / sigma, 2))))};
  }
  return Verdict{badness, c.kind == Unknown::mass ? std::string("it cannot be told from no mass at all")
                          : c.kind == Unknown::spring
                              ? std::string("it cannot be told from a rigid support")
                              : std::string("it is known to worse than a factor of 1.6")};
}

}  // namespace

fem::Body with_finite_supports(fem::Body body, const std::vector<std::string>& names, double compliance) {
  for (auto name = names.begin(); name != names.end(); ++name) {
    const std::string part = name->substr(name->find('.') + 1);
    for (auto other = names.begin(); other != name; ++other) {
      const bool same_part = other->substr(other->find('.') + 1) == part;
      const bool both = name->starts_with("both") || other->starts_with("both");
      if (*name == *other || (same_part && both))
        throw Error(fmt::format("fit: {} and {} cannot both be fitted, they are one number", *other, *name));
    }
    const Coordinate c = coordinate(body, *name);
    if (c.kind == Unknown::spring && !std::isfinite(c.number.value))
      body = fem::moved(body, fem::BodyNumber{.name = *name, .value = c.value(compliance)}, 0.0);
  }
  return body;
}

void check_joint_law(Kind law) {
  if (law != Kind::constant && law != Kind::power) {
    throw Error(
        fmt::format("fit: numbers of the body can be fitted beside a constant or a power law of the "
                    "modulus; a {} law follows whatever they do to the frequencies",
                    fem::to_string(law)));
  }
}

JointFit fit_body_numbers(const fem::Model& model, const fem::Eigenmodes& modes, int rigid,
                          const std::vector<PairedFrequency>& pairs, Kind law,
                          const std::vector<std::string>& names) {
  check_joint_law(law);
  JointFit result{model.body, {}, 0.0};
  std::vector<Coordinate> coordinates;
  for (const std::string& name : names) coordinates.push_back(coordinate(model.body, name));
  Problem problem(model, modes, rigid, pairs, law, coordinates);
  const Eigen::Index first = problem.law_size();
  const auto count = static_cast<Eigen::Index>(names.size());

  LeastSquares least_squares;
  least_squares.residual = [&](const Eigen::VectorXd& x) { return problem.residual(x); };
  least_squares.jacobian = [&](const Eigen::VectorXd& x) { return problem.jacobian(x); };
  Eigen::VectorXd start(count);
  const double infinity = std::numeric_limits<double>::infinity();
  least_squares.lower = Eigen::VectorXd::Constant(first + count, -infinity);
  least_squares.upper = Eigen::VectorXd::Constant(first + count, infinity);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Coordinate& c = coordinates[static_cast<std::size_t>(k)];
    start[k] = std::clamp(c.x(c.number.value), c.lower(), c.upper());
    least_squares.lower[first + k] = c.lower();
    least_squares.upper[first + k] = c.upper();
  }
  least_squares.start = problem.start(start);
  const LeastSquaresSolution solution = solve_least_squares(least_squares);

  const Eigen::MatrixXd jacobian = problem.jacobian(solution.x);
  const Eigen::MatrixXd covariance = full_covariance(jacobian, solution.rms());
  result.chi_square = solution.residual.squaredNorm();
  FittedNumbers& fitted = result.fitted;
  fitted.condition = condition_of(jacobian);
  if (jacobian.rows() <= jacobian.cols()) {
    fitted.inseparable = {
        {names.back(), fmt::format("{} paired modes for {} unknowns, the law's and the body's: one mode "
                                   "more than unknowns is needed",
                                   jacobian.rows(), jacobian.cols())}};
    return result;
  }
  std::optional<Verdict> worst;
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double alone = std::max(1.0, solution.rms()) / std::max(jacobian.col(first + k).norm(), 1e-300);
    const auto verdict = inseparable(coordinates[at], solution.x[first + k],
                                     std::sqrt(covariance(first + k, first + k)), alone, pairs.size());
    if (!verdict || (worst && worst->badness >= verdict->badness)) continue;
    worst = verdict;
    fitted.inseparable = {{names[at], verdict->reason}};
  }
  if (worst) return result;

  result.body = problem.body_at(solution.x.tail(count));
  fitted.name = names;
  fitted.value.resize(count);
  Eigen::VectorXd told(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Coordinate& c = coordinates[static_cast<std::size_t>(k)];
    fitted.value[k] = c.value(solution.x[first + k]);
    told[k] = c.told(solution.x[first + k]);
  }
  fitted.covariance = told.asDiagonal() * covariance.bottomRightCorner(count, count) * told.asDiagonal();
  return result;
}

}  // namespace struna::ident
