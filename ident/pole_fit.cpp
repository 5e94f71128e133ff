#include "ident/pole_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "fem/error.hpp"
#include "ident/line_blocks.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
constexpr double two_pi = 2.0 * std::numbers::pi;
constexpr int least_iterations = 3;  // on all lines
constexpr double smallest_loss_factor = 1e-7, largest_loss_factor = 1.5;

long residual_count(ResidualTerms terms) {
  return terms == ResidualTerms::constant ? 1 : terms == ResidualTerms::linear ? 2 : 3;
}

// d p_r / d(ln f, ln eta) in the sense that d g = g^2 * slope: structural -d lambda(1 + i eta), viscous d p.
std::array<Complex, 2> pole_slopes(const Pole& pole, fem::Damping damping) {
  const double omega = two_pi * pole.natural_frequency_hz, eta = pole.loss_factor;
  if (damping == fem::Damping::structural)
    return {-2.0 * omega * omega * Complex(1.0, eta), -omega * omega * Complex(0.0, eta)};
  const double zeta = 0.5 * eta;
  return {viscous_root(pole), -zeta * omega * Complex(1.0, zeta / std::sqrt(1.0 - zeta * zeta))};
}

// Everything at one set of poles. Columns are real: the real parts of all lines, then the imaginary parts.
struct State {
  std::vector<Pole> poles;
  Eigen::MatrixXd columns;            // unweighted: [linear | derivative]
  std::vector<Eigen::MatrixXd> gram;  // per distinct weight
  Eigen::MatrixXd coefficient;        // linear x outputs, in the columns' scale
  Eigen::MatrixXd residual;           // weighted, 2 lines x outputs
  double chi_square = 0.0;
};

struct Step {
  Eigen::VectorXd gradient;  // of -chi_square/2
  Eigen::MatrixXd hessian;
};

class Problem {
 public:
  Problem(const TransferFunction& tf, long poles, const PoleFitOptions& options)
      : options_(options),
        lines_(tf.lines()),
        outputs_(static_cast<long>(tf.outputs.size())),
        poles_(poles),
        linear_(2 * (poles + residual_count(options.residual))) {
    omega_ = two_pi * tf.frequency_hz;
    data_.resize(2 * lines_, outputs_);
    weight_.resize(2 * lines_, outputs_);
    for (long k = 0; k < outputs_; ++k) {
      const auto& output = tf.outputs[static_cast<std::size_t>(k)];
      data_.col(k) << output.value.real(), output.value.imag();
      weight_.col(k) << output.sigma.cwiseInverse(), output.sigma.cwiseInverse();
    }
    find_shared_weights();
    fill_residual_columns(tf.outputs.front().kind);
  }

  long linear() const { return linear_; }
  long lines() const { return lines_; }
  long outputs() const { return outputs_; }
  // Real data less real parameters.
  long degrees_of_freedom() const { return 2 * lines_ * outputs_ - linear_ * outputs_ - 2 * poles_; }

  State evaluate(const std::vector<Pole>& poles) const {
    State state;
    state.poles = poles;
    state.columns.resize(2 * lines_, linear_ + 2 * poles_);
    state.columns.middleCols(2 * poles_, linear_ - 2 * poles_) = residual_columns_;
    for (long r = 0; r < poles_; ++r) fill_pole_columns(poles[static_cast<std::size_t>(r)], r, state.columns);
    solve_linear(state);
    return state;
  }

  // Projected (Kaufman) gradient and Gauss-Newton Hessian in (ln f, ln eta) of all poles.
  Step step(const State& state) const {
    Step result{Eigen::VectorXd::Zero(2 * poles_), Eigen::MatrixXd::Zero(2 * poles_, 2 * poles_)};
    const Eigen::MatrixXd weighted = state.residual.cwiseProduct(weight_);
    const Eigen::MatrixXd against = state.columns.rightCols(2 * poles_).transpose() * weighted;
    for (long k = 0; k < outputs_; ++k) {
      const Eigen::MatrixXd chain = chain_rule(state, k);
      result.gradient += chain.transpose() * against.col(k);
    }
    std::vector<Eigen::MatrixXd> projected;
    for (const auto& gram : state.gram) projected.push_back(project(gram));
    for (long k = 0; k < outputs_; ++k) {
      const Eigen::MatrixXd chain = chain_rule(state, k);
      result.hessian += weight_factor_(k) * (chain.transpose() * projected[weight_group(k)] * chain);
    }
    return result;
  }

  PoleFit finish(const State& state, bool converged) const;

 private:
  std::size_t weight_group(long k) const { return shared_ ? 0 : static_cast<std::size_t>(k); }

  // Outputs whose weights differ by a factor only share one Gram matrix, the costly part.
  void find_shared_weights() {
    weight_factor_ = Eigen::VectorXd::Ones(outputs_);
    shared_ = true;
    for (long k = 1; k < outputs_ && shared_; ++k) {
      const Eigen::ArrayXd ratio = weight_.col(k).array() / weight_.col(0).array();
      shared_ = ratio.maxCoeff() - ratio.minCoeff() <= 1e-9 * ratio.maxCoeff();
    }
    if (!shared_) return;
    for (long k = 0; k < outputs_; ++k) weight_factor_(k) = std::pow(weight_(0, k) / weight_(0, 0), 2.0);
  }

  // Span of {1, w, w^2}/w (w = omega^2, for a mobility omega), as Legendre polynomials over the band: well
  // conditioned.
  void fill_residual_columns(FrfKind kind) {
    const long count = residual_count(options_.residual);
    Eigen::ArrayXd w = omega_.array();
    if (kind != FrfKind::mobility) w = w.square().eval();
    const double middle = 0.5 * (w(0) + w(lines_ - 1)), half = 0.5 * (w(lines_ - 1) - w(0));
    const Eigen::ArrayXd t = (w - middle) / half;
    const Eigen::ArrayXd inverse =
        options_.residual == ResidualTerms::band ? Eigen::ArrayXd(middle / w) : Eigen::ArrayXd::Ones(lines_);
    const std::array<Eigen::ArrayXd, 3> term = {inverse, inverse * t, inverse * (1.5 * t.square() - 0.5)};
    residual_columns_ = Eigen::MatrixXd::Zero(2 * lines_, 2 * count);
    for (long j = 0; j < count; ++j) {
      residual_columns_.col(2 * j).head(lines_) = term[static_cast<std::size_t>(j)];
      residual_columns_.col(2 * j + 1).tail(lines_) = term[static_cast<std::size_t>(j)];
    }
  }

  // Columns of Re C and Im C, and the same with g^2 in place of g, which serve every derivative.
  void fill_pole_columns(const Pole& pole, long r, Eigen::MatrixXd& columns) const {
    const double scale = pole_scale(pole, options_.damping);
    const bool mirror = options_.damping == fem::Damping::viscous && options_.conjugate_term;
    for (long i = 0; i < lines_; ++i) {
      const Complex g = scale * pole_function(pole, omega_(i), options_.damping);
      const Complex m = mirror ? std::conj(scale * pole_function(pole, -omega_(i), options_.damping)) : 0.0;
      put(columns, i, 2 * r, g, m);
      put(columns, i, linear_ + 2 * r, g * g, m * m);
    }
  }

  // a (g + m) + b i (g - m): the share of C = a + i b and its mirror image.
  void put(Eigen::MatrixXd& columns, long i, long first, const Complex& g, const Complex& m) const {
    columns(i, first) = g.real() + m.real();
    columns(lines_ + i, first) = g.imag() + m.imag();
    columns(i, first + 1) = -g.imag() + m.imag();
    columns(lines_ + i, first + 1) = g.real() - m.real();
  }

  void solve_linear(State& state) const {
    const long groups = shared_ ? 1 : outputs_;
    state.gram.resize(static_cast<std::size_t>(groups));
    state.coefficient.resize(linear_, outputs_);
    const auto linear_columns = state.columns.leftCols(linear_);
    for (long g = 0; g < groups; ++g) {
      const Eigen::MatrixXd weighted = weight_.col(g).asDiagonal() * state.columns;
      auto& gram = state.gram[static_cast<std::size_t>(g)];
      gram = Eigen::MatrixXd::Zero(weighted.cols(), weighted.cols());
      gram.selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
      gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
      const auto factor = factorise(gram);
      // A second pass on the residual takes back what the squared condition number costs.
      for (long k = g; k < (shared_ ? outputs_ : g + 1); ++k) {
        const auto squared = weight_.col(k).cwiseAbs2();
        const double share = 1.0 / weight_factor_(k);
        Eigen::VectorXd c =
            share * solve(factor, linear_columns.transpose() * squared.cwiseProduct(data_.col(k)));
        const Eigen::VectorXd rest = squared.cwiseProduct(data_.col(k) - linear_columns * c);
        c += share * solve(factor, linear_columns.transpose() * rest);
        state.coefficient.col(k) = c;
      }
    }
    state.residual = (data_ - linear_columns * state.coefficient).cwiseProduct(weight_);
    state.chi_square = state.residual.squaredNorm();
  }

  // Cholesky factor of the linear part, scaled to unit diagonal; the ridge keeps coinciding poles solvable.
  struct Factor {
    Eigen::VectorXd scale;
    Eigen::LLT<Eigen::MatrixXd> llt;
  };
  Factor factorise(const Eigen::MatrixXd& gram) const {
    Factor factor;
    factor.scale = gram.diagonal().head(linear_).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled =
        factor.scale.asDiagonal() * gram.topLeftCorner(linear_, linear_) * factor.scale.asDiagonal();
    scaled.diagonal().array() += 1e-13;
    factor.llt.compute(scaled);
    return factor;
  }
  static Eigen::MatrixXd solve(const Factor& factor, const Eigen::MatrixXd& right) {
    return factor.scale.asDiagonal() * factor.llt.solve(factor.scale.asDiagonal() * right);
  }

  // Gram matrix of the derivative columns, less what the linear columns explain of it.
  Eigen::MatrixXd project(const Eigen::MatrixXd& gram) const {
    const Eigen::MatrixXd cross = gram.topRightCorner(linear_, 2 * poles_);
    return gram.bottomRightCorner(2 * poles_, 2 * poles_) - cross.transpose() * solve(factorise(gram), cross);
  }

  // d(model of output k)/d(ln f_r, ln eta_r) in the derivative columns.
  Eigen::MatrixXd chain_rule(const State& state, long k) const {
    Eigen::MatrixXd chain = Eigen::MatrixXd::Zero(2 * poles_, 2 * poles_);
    for (long r = 0; r < poles_; ++r) {
      const Pole& pole = state.poles[static_cast<std::size_t>(r)];
      const Complex constant(state.coefficient(2 * r, k), state.coefficient(2 * r + 1, k));
      const auto slopes = pole_slopes(pole, options_.damping);
      for (long t = 0; t < 2; ++t) {
        const Complex d = constant * slopes[static_cast<std::size_t>(t)] / pole_scale(pole, options_.damping);
        chain(2 * r, 2 * r + t) = d.real();
        chain(2 * r + 1, 2 * r + t) = d.imag();
      }
    }
    return chain;
  }

  double line_correlation(const Eigen::MatrixXcd& residual) const;

  PoleFitOptions options_;
  long lines_, outputs_, poles_, linear_;
  Eigen::VectorXd omega_;
  Eigen::MatrixXd data_, weight_, residual_columns_;
  Eigen::VectorXd weight_factor_;
  bool shared_ = false;
};

// Up to three lines apart, as far as a Hann window reaches; what is within the autocorrelation's own scatter
// counts as none.
double Problem::line_correlation(const Eigen::MatrixXcd& residual) const {
  const double power = residual.squaredNorm();
  double sum = 1.0;
  for (long lag = 1; lag <= 3 && lag < lines_; ++lag) {
    const Complex product =
        residual.topRows(lines_ - lag).conjugate().cwiseProduct(residual.bottomRows(lines_ - lag)).sum();
    const double correlation = power > 0.0 ? product.real() / power : 0.0;
    if (correlation > 2.0 / std::sqrt(2.0 * static_cast<double>(lines_ * outputs_))) sum += 2.0 * correlation;
  }
  return sum;
}

PoleFit Problem::finish(const State& state, bool converged) const {
  PoleFit fit;
  fit.poles = state.poles;
  fit.converged = converged;
  fit.chi_square = state.chi_square;
  fit.degrees_of_freedom = degrees_of_freedom();
  const Eigen::MatrixXd model = state.columns.leftCols(linear_) * state.coefficient;
  fit.fitted = model.topRows(lines_) + Complex(0.0, 1.0) * model.bottomRows(lines_);
  fit.residual = state.residual.topRows(lines_) + Complex(0.0, 1.0) * state.residual.bottomRows(lines_);
  fit.line_correlation = line_correlation(fit.residual);
  fit.constant.resize(poles_, outputs_);
  fit.constant_sigma.resize(poles_, outputs_);
  fit.covariance.resize(2 * poles_, 2 * poles_);
  if (poles_ == 0) return fit;

  const double scatter =
      fit.degrees_of_freedom > 0 ? fit.chi_square / static_cast<double>(fit.degrees_of_freedom) : 1.0;
  const double noise = fit.line_correlation * (options_.sigma_known ? std::max(1.0, scatter) : scatter);
  Eigen::MatrixXd hessian = step(state).hessian;
  const Eigen::VectorXd scale = hessian.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  hessian = scale.asDiagonal() * hessian * scale.asDiagonal();
  const Eigen::MatrixXd inverse = hessian.ldlt().solve(Eigen::MatrixXd::Identity(2 * poles_, 2 * poles_));
  const Eigen::MatrixXd covariance = scale.asDiagonal() * inverse * scale.asDiagonal();
  Eigen::VectorXd chain(2 * poles_);
  for (long r = 0; r < poles_; ++r) {
    const Pole& pole = state.poles[static_cast<std::size_t>(r)];
    chain.segment<2>(2 * r) << pole.natural_frequency_hz, pole.loss_factor;
  }
  fit.covariance = noise * chain.asDiagonal() * covariance * chain.asDiagonal();

  for (long k = 0; k < outputs_; ++k) {
    const auto& gram = state.gram[weight_group(k)];
    const Factor factor = factorise(gram);
    const Eigen::MatrixXd linear_part =
        solve(factor, Eigen::MatrixXd::Identity(linear_, linear_)) / weight_factor_(k);
    const Eigen::MatrixXd through =
        solve(factor, gram.topRightCorner(linear_, 2 * poles_)) * chain_rule(state, k);
    const Eigen::VectorXd variance =
        linear_part.diagonal() + (through * covariance).cwiseProduct(through).rowwise().sum();
    for (long r = 0; r < poles_; ++r) {
      const double to_constant = pole_scale(state.poles[static_cast<std::size_t>(r)], options_.damping);
      fit.constant(r, k) =
          to_constant * Complex(state.coefficient(2 * r, k), state.coefficient(2 * r + 1, k));
      fit.constant_sigma(r, k) =
          to_constant * std::sqrt(noise * 0.5 * (variance(2 * r) + variance(2 * r + 1)));
    }
  }
  return fit;
}

// Poles moved by `delta` (ln f, ln eta), the whole step shortened so that none goes farther than a bandwidth
// or changes its damping by more than a factor e.
std::vector<Pole> moved(const std::vector<Pole>& poles, const Eigen::VectorXd& delta) {
  double share = 1.0;
  for (std::size_t r = 0; r < poles.size(); ++r) {
    const double f_step = std::abs(delta(2 * r)), eta_step = std::abs(delta(2 * r + 1));
    share =
        std::min({share, poles[r].loss_factor / std::max(f_step, 1e-300), 1.0 / std::max(eta_step, 1e-300)});
  }
  std::vector<Pole> result = poles;
  for (std::size_t r = 0; r < poles.size(); ++r) {
    result[r].natural_frequency_hz *= std::exp(share * delta(2 * r));
    result[r].loss_factor = std::clamp(poles[r].loss_factor * std::exp(share * delta(2 * r + 1)),
                                       smallest_loss_factor, largest_loss_factor);
  }
  return result;
}

// Largest move of any pole, in bandwidths and parts of its damping.
double size_of(const Eigen::VectorXd& delta, const std::vector<Pole>& poles) {
  double size = 0.0;
  for (std::size_t r = 0; r < poles.size(); ++r)
    size = std::max({size, std::abs(delta(2 * r)) / poles[r].loss_factor, std::abs(delta(2 * r + 1))});
  return size;
}

void check(const TransferFunction& tf, const std::vector<Pole>& start) {
  if (tf.lines() < 2 || tf.outputs.empty())
    throw Error(fmt::format("fit_poles: at least 2 lines and an output, got {} and {}", tf.lines(),
                            tf.outputs.size()));
  for (const Pole& pole : start)
    if (!(pole.natural_frequency_hz > 0.0) || !(pole.loss_factor > 0.0) ||
        pole.loss_factor > largest_loss_factor)
      throw Error(
          fmt::format("fit_poles: start with frequency > 0 and 0 < loss factor <= {}, got {} Hz and {}",
                      largest_loss_factor, pole.natural_frequency_hz, pole.loss_factor));
  for (const auto& output : tf.outputs)
    if (output.sigma.size() != tf.lines() || output.value.size() != tf.lines())
      throw Error(fmt::format("fit_poles: value and sigma of output \"{}\" on all {} lines, got {} and {}",
                              output.name, tf.lines(), output.value.size(), output.sigma.size()));
}

struct Outcome {
  bool converged = false;
  int iterations = 0;
};

// Levenberg-Marquardt from `state` until less than `tolerance` standard errors is to be gained. Where the
// residual is large (the model lacks something), the true curvature is c times that of Gauss and Newton
// and their steps overshoot to and fro, by c - 1 each. The decrease of such a step is 2 - c of the promised
// one: half of what that lacks as damping brings either kind of direction home at a like rate.
Outcome minimise(const Problem& problem, int max_iterations, double tolerance, State& state) {
  constexpr double least_damping = 1e-4, damping_after_failure = 0.03;
  double damping = least_damping;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const Step step = problem.step(state);
    bool accepted = false;
    while (!accepted && damping < 1e12) {
      Eigen::MatrixXd lhs = step.hessian;
      lhs.diagonal() *= 1.0 + damping;
      const Eigen::VectorXd delta = lhs.ldlt().solve(step.gradient);
      const double promise = delta.dot(step.gradient);
      const double per_dof = state.chi_square / static_cast<double>(problem.degrees_of_freedom());
      if (size_of(delta, state.poles) < 1e-12 || promise < tolerance * tolerance * per_dof)
        return {true, iteration};
      State trial = problem.evaluate(moved(state.poles, delta));
      if (trial.chi_square < state.chi_square) {
        const double kept = std::clamp((state.chi_square - trial.chi_square) / promise, 0.0, 1.0);
        damping = std::max({least_damping, 0.1 * damping, 0.5 * (1.0 - kept)});
        state = std::move(trial);
        accepted = true;
      } else {
        if (promise < 1e-12 * state.chi_square) return {true, iteration};  // the decrease drowns in rounding
        damping = std::max(damping_after_failure, 10.0 * damping);
      }
    }
    if (!accepted) return {false, iteration};
  }
  return {false, max_iterations};
}

// Where many lines are worth few blocks, what fits these is the better start: poles, and iterations spent.
std::pair<std::vector<Pole>, int> from_blocks(const TransferFunction& tf, const std::vector<Pole>& start,
                                              const PoleFitOptions& options) {
  const TransferFunction blocks = in_blocks(tf, start);
  if (2 * blocks.lines() > tf.lines()) return {start, 0};
  const Problem problem(blocks, static_cast<long>(start.size()), options);
  if (problem.degrees_of_freedom() < 1) return {start, 0};
  State state = problem.evaluate(start);
  const Outcome outcome = minimise(problem, options.max_iterations, options.tolerance, state);
  return {state.poles, outcome.converged ? 0 : outcome.iterations};
}

}  // namespace

PoleFit fit_poles(const TransferFunction& tf, const std::vector<Pole>& start, const PoleFitOptions& options) {
  check(tf, start);
  const Problem problem(tf, static_cast<long>(start.size()), options);
  if (problem.degrees_of_freedom() < 1)
    throw Error(fmt::format(
        "fit_poles: {} modes in {} outputs need more lines than {}; widen the band or fit fewer modes",
        start.size(), tf.outputs.size(), tf.lines()));
  if (start.empty()) return problem.finish(problem.evaluate(start), true);
  const auto [nearer, spent] = from_blocks(tf, start, options);
  State state = problem.evaluate(nearer);
  const int left = std::max(least_iterations, options.max_iterations - spent);
  const Outcome outcome = minimise(problem, left, options.tolerance, state);
  return problem.finish(state, outcome.converged);
}

Mode to_mode(const PoleFit& fit, long r, fem::Damping damping) {
  const Pole& pole = fit.poles[static_cast<std::size_t>(r)];
  Mode mode;
  mode.natural_frequency_hz = pole.natural_frequency_hz;
  mode.loss_factor = pole.loss_factor;
  mode.damping_ratio = 0.5 * pole.loss_factor;
  mode.natural_frequency_sigma = std::sqrt(fit.covariance(2 * r, 2 * r));
  mode.loss_factor_sigma = std::sqrt(fit.covariance(2 * r + 1, 2 * r + 1));
  mode.lower_half_power_hz = lower_half_power_hz(pole, damping);
  mode.upper_half_power_hz = upper_half_power_hz(pole, damping);
  mode.modal_constant = fit.constant.row(r).transpose();
  mode.modal_constant_sigma = fit.constant_sigma.row(r).transpose();
  mode.circle_natural_frequency_hz = mode.circle_loss_factor = std::numeric_limits<double>::quiet_NaN();
  if (!fit.converged) mode.flags.push_back(ModeFlag::not_converged);
  return mode;
}

}  // namespace struna::ident
