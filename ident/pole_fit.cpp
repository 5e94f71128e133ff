#include "ident/pole_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "fem/error.hpp"
#include "ident/line_blocks.hpp"
#include "ident/separable_minimum.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
constexpr double two_pi = 2.0 * std::numbers::pi;
constexpr int least_iterations = 3;  // on all lines
constexpr double largest_loss_factor = 1.5;

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
    const bool mirror = options_.damping == fem::Damping::viscous && options_.conjugate_term;
    for (long r = 0; r < poles_; ++r)
      fill_pole_columns(poles[static_cast<std::size_t>(r)], omega_, options_.damping, mirror, 2 * r,
                        linear_ + 2 * r, state.columns);
    solve_linear(state);
    return state;
  }

  // Projected (Kaufman) gradient and Gauss-Newton Hessian in (ln f, ln eta) of all poles.
  Step unbounded_step(const State& state) const {
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

  Step step(const State& state) const {
    Step result = unbounded_step(state);
    hold_at_bounds(state.poles, result.gradient, result.hessian);
    return result;
  }

  State moved(const State& state, const Eigen::VectorXd& delta) const {
    return evaluate(ident::moved(state.poles, delta));
  }
  // Largest move of any pole, in bandwidths and parts of its damping.
  double size_of(const Eigen::VectorXd& delta, const State& state) const {
    return ident::size_of(delta, state.poles);
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

  void fill_residual_columns(FrfKind kind) {
    const Eigen::MatrixXd shapes = residual_shapes(omega_, kind, options_.residual);
    residual_columns_ = Eigen::MatrixXd::Zero(2 * lines_, 2 * shapes.cols());
    for (long j = 0; j < shapes.cols(); ++j) {
      residual_columns_.col(2 * j).head(lines_) = shapes.col(j);
      residual_columns_.col(2 * j + 1).tail(lines_) = shapes.col(j);
    }
  }

  // Covariance of the gradient when outputs share their noise: sum over pairs of outputs of Re(rho_kl J_k^H
  // J_l), J the projected derivatives; without shared noise the Hessian.
  Eigen::MatrixXd score_covariance(const State& state, const Eigen::MatrixXcd& shared) const {
    std::vector<Eigen::MatrixXcd> derivative;
    for (long k = 0; k < outputs_; ++k) {
      const auto& gram = state.gram[weight_group(k)];
      const Eigen::MatrixXd cross = gram.topRightCorner(linear_, 2 * poles_);
      const Eigen::MatrixXd own = weight_.col(k).asDiagonal() *
                                  (state.columns.rightCols(2 * poles_) -
                                   state.columns.leftCols(linear_) * solve(factorise(gram), cross)) *
                                  chain_rule(state, k);
      derivative.push_back(own.topRows(lines_) + Complex(0.0, 1.0) * own.bottomRows(lines_));
    }
    return score_covariance_of(derivative, shared);
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
      const auto slopes = scaled_slopes(pole, options_.damping);
      for (long t = 0; t < 2; ++t) {
        const Complex d = constant * slopes[static_cast<std::size_t>(t)];
        chain(2 * r, 2 * r + t) = d.real();
        chain(2 * r + 1, 2 * r + t) = d.imag();
      }
    }
    return chain;
  }

  PoleFitOptions options_;
  long lines_, outputs_, poles_, linear_;
  Eigen::VectorXd omega_;
  Eigen::MatrixXd data_, weight_, residual_columns_;
  Eigen::VectorXd weight_factor_;
  bool shared_ = false;
};

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
  Step last = unbounded_step(state);
  Eigen::MatrixXd hessian = last.hessian;
  const Eigen::VectorXd scale = hessian.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  hessian = scale.asDiagonal() * hessian * scale.asDiagonal();
  const Eigen::MatrixXd inverse = hessian.ldlt().solve(Eigen::MatrixXd::Identity(2 * poles_, 2 * poles_));
  Eigen::MatrixXd covariance = scale.asDiagonal() * inverse * scale.asDiagonal();
  const Eigen::MatrixXcd shared = shared_noise(fit.residual, fit.line_correlation);
  if (!shared.isIdentity(0.0)) covariance = covariance * score_covariance(state, shared) * covariance;
  Eigen::VectorXd chain(2 * poles_);
  for (long r = 0; r < poles_; ++r) {
    const Pole& pole = state.poles[static_cast<std::size_t>(r)];
    chain.segment<2>(2 * r) << pole.natural_frequency_hz, pole.loss_factor;
  }
  fit.covariance = noise * chain.asDiagonal() * covariance * chain.asDiagonal();
  hold_at_bounds(state.poles, last.gradient, last.hessian);
  fit.unsettled = unsettled_by(damped_step(last.hessian, last.gradient, 0.0), fit);

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

Eigen::VectorXd unsettled_by(const Eigen::VectorXd& step, const PoleFit& fit) {
  Eigen::VectorXd moves(static_cast<long>(fit.poles.size()));
  for (long r = 0; r < moves.size(); ++r) {
    const Pole& pole = fit.poles[static_cast<std::size_t>(r)];
    const double f = step(2 * r) * pole.natural_frequency_hz, eta = step(2 * r + 1) * pole.loss_factor;
    moves(r) = std::max(std::abs(f) / std::sqrt(fit.covariance(2 * r, 2 * r)),
                        std::abs(eta) / std::sqrt(fit.covariance(2 * r + 1, 2 * r + 1)));
  }
  return moves;
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
  constexpr double settled = 0.1;  // standard errors: what nobody can see
  if (!fit.converged && !(fit.unsettled(r) < settled)) mode.flags.push_back(ModeFlag::not_converged);
  return mode;
}

}  // namespace struna::ident
