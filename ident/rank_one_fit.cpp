#include "ident/rank_one_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "fem/error.hpp"
#include "ident/separable_minimum.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Multiplication by a complex number, on (re, im).
Eigen::Matrix2d turned(const Complex& z) {
  return (Eigen::Matrix2d() << z.real(), -z.imag(), z.imag(), z.real()).finished();
}

// One column (output under reference) at one set of poles, its residual terms eliminated: products of the
// pole columns [g of all poles | g^2 of all poles] with each other and with the data.
struct Column {
  MatrixXd gram;
  VectorXd against;
};

struct State {
  std::vector<Pole> poles;
  MatrixXcd participation;      // references x poles
  std::vector<long> held;       // the reference of each pole whose participation is 1
  std::vector<Column> columns;  // per column of the function
  MatrixXd shape;               // u: (re, im) of each pole x outputs
  double chi_square = 0.0;
};

struct Step {
  VectorXd gradient;  // of -chi_square/2
  MatrixXd hessian;
};

// What is common to all evaluations: the lines of each column, weighted, without what residual terms explain.
class Lines {
 public:
  Lines(const TransferFunction& tf, const PoleFitOptions& options) : options_(options) {
    omega_ = 2.0 * std::numbers::pi * tf.frequency_hz;
    const MatrixXd shapes = residual_shapes(omega_, tf.outputs.front().kind, options.residual);
    for (const auto& output : tf.outputs) {
      weight_.push_back(output.sigma.cwiseInverse());
      const MatrixXd weighted = weight_.back().asDiagonal() * shapes;
      const Eigen::HouseholderQR<MatrixXd> qr(weighted);
      basis_.push_back(qr.householderQ() * MatrixXd::Identity(weighted.rows(), weighted.cols()));
      MatrixXd data(2 * lines(), 1);
      data << output.value.real(), output.value.imag();
      data_.push_back(projected(std::move(data), weight_.size() - 1));
    }
  }

  long lines() const { return omega_.size(); }
  std::size_t columns() const { return data_.size(); }
  const MatrixXd& data(std::size_t k) const { return data_[k]; }

  // 2 lines x 4 poles, not weighted.
  MatrixXd pole_columns(const std::vector<Pole>& poles) const {
    const long count = static_cast<long>(poles.size());
    MatrixXd all(2 * lines(), 4 * count);
    const bool mirror = options_.damping == fem::Damping::viscous && options_.conjugate_term;
    for (long r = 0; r < count; ++r)
      fill_pole_columns(poles[static_cast<std::size_t>(r)], omega_, options_.damping, mirror, 2 * r,
                        2 * (count + r), all);
    return all;
  }
  MatrixXd projected(MatrixXd values, std::size_t k) const {
    const MatrixXd& q = basis_[k];
    for (auto half : {values.topRows(lines()), values.bottomRows(lines())}) {
      half = (weight_[k].asDiagonal() * half).eval();
      half -= (q * (q.transpose() * half)).eval();
    }
    return values;
  }
  std::vector<Column> products(const std::vector<Pole>& poles) const {
    const MatrixXd unweighted = pole_columns(poles);
    std::vector<Column> all;
    for (std::size_t k = 0; k < columns(); ++k) {
      const MatrixXd own = projected(unweighted, k);
      all.push_back({own.transpose() * own, own.transpose() * data_[k]});
    }
    return all;
  }

 private:
  PoleFitOptions options_;
  VectorXd omega_;
  std::vector<VectorXd> weight_;
  std::vector<MatrixXd> basis_;  // of the residual terms, orthonormal
  std::vector<MatrixXd> data_;
};

// Of a positive matrix, scaled to unit diagonal first; the ridge keeps coinciding poles solvable.
MatrixXd inverse_of(const MatrixXd& gram) {
  const VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  MatrixXd scaled = scale.asDiagonal() * gram * scale.asDiagonal();
  scaled.diagonal().array() += 1e-13;
  const MatrixXd inverse = scaled.ldlt().solve(MatrixXd::Identity(gram.rows(), gram.cols()));
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

class Problem {
 public:
  Problem(const TransferFunction& tf, const References& references, long poles, const PoleFitOptions& options)
      : options_(options),
        lines_(tf, options),
        references_(references),
        outputs_(references.column.rows()),
        inputs_(references.column.cols()),
        poles_(poles) {}

  long degrees_of_freedom() const {
    const long columns = static_cast<long>(lines_.columns());
    const long residual = 2 * residual_count(options_.residual) * columns;
    return 2 * lines_.lines() * columns - residual - poles_ * (2 + 2 * outputs_ + 2 * (inputs_ - 1));
  }

  State evaluate(std::vector<Pole> poles, MatrixXcd participation) const {
    State state;
    state.poles = std::move(poles);
    state.participation = std::move(participation);
    for (long r = 0; r < poles_; ++r) {
      long largest = 0;
      state.participation.col(r).cwiseAbs().maxCoeff(&largest);
      state.participation.col(r) /= Complex(state.participation(largest, r));
      state.participation(largest, r) = 1.0;
      state.held.push_back(largest);
    }
    state.columns = lines_.products(state.poles);
    state.shape.resize(2 * poles_, outputs_);
    for (std::size_t k = 0; k < lines_.columns(); ++k) state.chi_square += lines_.data(k).squaredNorm();
    for (long o = 0; o < outputs_; ++o) {
      VectorXd against = VectorXd::Zero(2 * poles_);
      for_each_column(o, [&](long j, std::size_t k) {
        against += turn(state, j).transpose() * state.columns[k].against.head(2 * poles_);
      });
      state.shape.col(o) = inverse_of(normal(state, o)) * against;
      state.chi_square -= against.dot(state.shape.col(o));
    }
    return state;
  }

  State moved(const State& state, const VectorXd& delta) const {
    double share = 1.0;
    std::vector<Pole> poles = ident::moved(state.poles, delta.head(2 * poles_), &share);
    MatrixXcd participation = state.participation;
    for (long r = 0; r < poles_; ++r)
      for (long j = 0; j < inputs_; ++j) {
        const long at = participation_at(r, j);
        participation(j, r) += share * Complex(delta(at), delta(at + 1));
      }
    return evaluate(std::move(poles), std::move(participation));
  }

  double size_of(const VectorXd& delta, const State& state) const {
    return std::max(ident::size_of(delta.head(2 * poles_), state.poles),
                    delta.tail(delta.size() - 2 * poles_).cwiseAbs().maxCoeff());
  }

  Step step(const State& state) const {
    Step result = unbounded_step(state);
    hold_at_bounds(state.poles, result.gradient, result.hessian);
    return result;
  }

  Step unbounded_step(const State& state) const {
    Step result{VectorXd::Zero(unknowns()), MatrixXd::Zero(unknowns(), unknowns())};
    for (long o = 0; o < outputs_; ++o) {
      for_each_column(o, [&](long j, std::size_t k) {
        const MatrixXd e = effect(state, o, j);
        const VectorXd rest =
            state.columns[k].against - state.columns[k].gram.leftCols(2 * poles_) * constants(state, o, j);
        result.gradient += e.transpose() * rest;
        result.hessian += e.transpose() * state.columns[k].gram * e;
      });
      const MatrixXd through = coupling(state, o);
      result.hessian -= through.transpose() * inverse_of(normal(state, o)) * through;
    }
    // The participation that is held at one does not move.
    for (long r = 0; r < poles_; ++r) {
      const long first = participation_at(r, state.held[static_cast<std::size_t>(r)]);
      for (long at = first; at < first + 2; ++at) {
        result.gradient(at) = 0.0;
        result.hessian.row(at).setZero();
        result.hessian.col(at).setZero();
        result.hessian(at, at) = 1.0;
      }
    }
    return result;
  }

  RankOneFit finish(const State& state, bool converged) const;

 private:
  long unknowns() const { return 2 * poles_ + 2 * poles_ * inputs_; }
  long participation_at(long r, long j) const { return 2 * poles_ + 2 * (r * inputs_ + j); }

  template <class Use>
  void for_each_column(long o, Use use) const {
    for (long j = 0; j < inputs_; ++j)
      if (references_.column(o, j) >= 0) use(j, static_cast<std::size_t>(references_.column(o, j)));
  }

  // From shapes to constants under reference j.
  MatrixXd turn(const State& state, long j) const {
    MatrixXd all = MatrixXd::Zero(2 * poles_, 2 * poles_);
    for (long r = 0; r < poles_; ++r) all.block<2, 2>(2 * r, 2 * r) = turned(state.participation(j, r));
    return all;
  }
  VectorXd constants(const State& state, long o, long j) const { return turn(state, j) * state.shape.col(o); }

  MatrixXd normal(const State& state, long o) const {
    MatrixXd sum = MatrixXd::Zero(2 * poles_, 2 * poles_);
    for_each_column(o, [&](long j, std::size_t k) {
      const MatrixXd t = turn(state, j);
      sum += t.transpose() * state.columns[k].gram.topLeftCorner(2 * poles_, 2 * poles_) * t;
    });
    return sum;
  }

  // d(coefficients of [g | g^2])/d(ln f, ln eta of all poles, participations), shapes held.
  MatrixXd effect(const State& state, long o, long j) const {
    MatrixXd e = MatrixXd::Zero(4 * poles_, unknowns());
    const VectorXd c = constants(state, o, j);
    for (long r = 0; r < poles_; ++r) {
      const auto slopes = scaled_slopes(state.poles[static_cast<std::size_t>(r)], options_.damping);
      for (long t = 0; t < 2; ++t)
        e.block<2, 1>(2 * (poles_ + r), 2 * r + t) =
            turned(slopes[static_cast<std::size_t>(t)]) * c.segment<2>(2 * r);
      const Complex u(state.shape(2 * r, o), state.shape(2 * r + 1, o));
      e.block<2, 2>(2 * r, participation_at(r, j)) = turned(u);
    }
    return e;
  }
  // Products of the shapes' columns with those of the unknowns.
  MatrixXd coupling(const State& state, long o) const {
    MatrixXd sum = MatrixXd::Zero(2 * poles_, unknowns());
    for_each_column(o, [&](long j, std::size_t k) {
      sum += turn(state, j).transpose() * state.columns[k].gram.topRows(2 * poles_) * effect(state, o, j);
    });
    return sum;
  }

  // Of the model in the unknowns, shapes and residual terms eliminated: lines x unknowns per column.
  std::vector<MatrixXcd> derivatives(const State& state) const {
    const MatrixXd unweighted = lines_.pole_columns(state.poles);
    std::vector<MatrixXcd> all(lines_.columns());
    for (long o = 0; o < outputs_; ++o) {
      const MatrixXd through = inverse_of(normal(state, o)) * coupling(state, o);
      for_each_column(o, [&](long j, std::size_t k) {
        MatrixXd moves = effect(state, o, j);
        moves.topRows(2 * poles_) -= turn(state, j) * through;
        const MatrixXd own = lines_.projected(unweighted, k) * moves;
        all[k] = own.topRows(lines_.lines()) + Complex(0.0, 1.0) * own.bottomRows(lines_.lines());
      });
    }
    return all;
  }
  void set_residual(const State& state, RankOneFit& fit) const;
  void set_constants(const State& state, const MatrixXd& covariance, double noise, RankOneFit& fit) const;

  PoleFitOptions options_;
  Lines lines_;
  References references_;
  long outputs_, inputs_, poles_;
};

void Problem::set_residual(const State& state, RankOneFit& fit) const {
  const long n = lines_.lines();
  const MatrixXd unweighted = lines_.pole_columns(state.poles);
  fit.residual.resize(n, static_cast<long>(lines_.columns()));
  for (long o = 0; o < outputs_; ++o)
    for_each_column(o, [&](long j, std::size_t k) {
      const VectorXd rest =
          lines_.data(k) - lines_.projected(unweighted.leftCols(2 * poles_), k) * constants(state, o, j);
      fit.residual.col(static_cast<long>(k)) = rest.head(n) + Complex(0.0, 1.0) * rest.tail(n);
    });
  fit.line_correlation = line_correlation(fit.residual);
}

void Problem::set_constants(const State& state, const MatrixXd& covariance, double noise,
                            RankOneFit& fit) const {
  fit.constant.resize(poles_, static_cast<long>(lines_.columns()));
  fit.constant_sigma.resize(poles_, fit.constant.cols());
  fit.rank_excess = VectorXd::Zero(poles_);
  for (long o = 0; o < outputs_; ++o) {
    const MatrixXd inverse = inverse_of(normal(state, o));
    const MatrixXd through = inverse * coupling(state, o);
    for_each_column(o, [&](long j, std::size_t k) {
      const MatrixXd t = turn(state, j);
      const MatrixXd moves = effect(state, o, j).topRows(2 * poles_) - t * through;
      const VectorXd variance =
          (t * inverse * t.transpose() + moves * covariance * moves.transpose()).diagonal();
      const VectorXd c = constants(state, o, j);
      const MatrixXd free_covariance =
          inverse_of(state.columns[k].gram.topLeftCorner(2 * poles_, 2 * poles_));
      const VectorXd freed = free_covariance * state.columns[k].against.head(2 * poles_) - c;
      for (long r = 0; r < poles_; ++r) {
        const double scale = pole_scale(state.poles[static_cast<std::size_t>(r)], options_.damping);
        const long column = static_cast<long>(k);
        fit.constant(r, column) = scale * Complex(c(2 * r), c(2 * r + 1));
        fit.constant_sigma(r, column) =
            scale * std::sqrt(noise * 0.5 * (variance(2 * r) + variance(2 * r + 1)));
        const Eigen::Vector2d own = freed.segment<2>(2 * r);
        const Eigen::Matrix2d spread = free_covariance.block<2, 2>(2 * r, 2 * r);
        fit.rank_excess(r) += own.dot(spread.ldlt().solve(own)) / noise;
      }
    });
  }
}

RankOneFit Problem::finish(const State& state, bool converged) const {
  RankOneFit fit;
  fit.poles = state.poles;
  fit.participation = state.participation;
  fit.converged = converged;
  fit.degrees_of_freedom = degrees_of_freedom();
  set_residual(state, fit);
  fit.chi_square = fit.residual.squaredNorm();
  const double scatter = fit.chi_square / static_cast<double>(fit.degrees_of_freedom);
  const double noise = fit.line_correlation * (options_.sigma_known ? std::max(1.0, scatter) : scatter);
  Step last = unbounded_step(state);
  MatrixXd covariance = inverse_of(last.hessian);
  const MatrixXcd shared = shared_noise(fit.residual, fit.line_correlation);
  if (!shared.isIdentity(0.0))
    covariance = covariance * score_covariance_of(derivatives(state), shared) * covariance;
  for (long r = 0; r < poles_; ++r) {  // what is held has no error
    const long held = participation_at(r, state.held[static_cast<std::size_t>(r)]);
    covariance.middleRows(held, 2).setZero();
    covariance.middleCols(held, 2).setZero();
  }
  VectorXd chain(2 * poles_);
  for (long r = 0; r < poles_; ++r)
    chain.segment<2>(2 * r) << state.poles[static_cast<std::size_t>(r)].natural_frequency_hz,
        state.poles[static_cast<std::size_t>(r)].loss_factor;
  fit.covariance =
      noise * chain.asDiagonal() * covariance.topLeftCorner(2 * poles_, 2 * poles_) * chain.asDiagonal();
  hold_at_bounds(state.poles, last.gradient, last.hessian);
  fit.unsettled = unsettled_by(damped_step(last.hessian, last.gradient, 0.0).head(2 * poles_), fit);
  set_constants(state, covariance, noise, fit);
  return fit;
}

// Values per column as outputs x references, zero where not measured.
MatrixXcd in_table(const References& references, const Eigen::VectorXcd& values) {
  MatrixXcd table = MatrixXcd::Zero(references.column.rows(), references.column.cols());
  for (long o = 0; o < table.rows(); ++o)
    for (long j = 0; j < table.cols(); ++j)
      if (references.column(o, j) >= 0) table(o, j) = values(references.column(o, j));
  return table;
}

// Pole moved by what s makes of the coefficient of g^2, at most a bandwidth.
Pole moved_by(const Pole& pole, const Complex& s, fem::Damping damping) {
  const auto slopes = scaled_slopes(pole, damping);
  const Eigen::Matrix2d columns =
      (Eigen::Matrix2d() << slopes[0].real(), slopes[1].real(), slopes[0].imag(), slopes[1].imag())
          .finished();
  Eigen::Vector2d delta = columns.inverse() * Eigen::Vector2d(s.real(), s.imag());
  delta(0) = std::clamp(delta(0), -pole.loss_factor, pole.loss_factor);
  delta(1) = std::clamp(delta(1), -0.5, 0.5);
  return {pole.natural_frequency_hz * std::exp(delta(0)), pole.loss_factor * std::exp(delta(1))};
}

}  // namespace

RankOneFit fit_rank_one(const TransferFunction& tf, const References& references,
                        const std::vector<Pole>& start, const MatrixXcd& start_participation,
                        const PoleFitOptions& options) {
  if (start.empty() || start_participation.cols() != static_cast<long>(start.size()) ||
      start_participation.rows() != references.column.cols())
    throw Error(fmt::format(
        "fit_rank_one: at least one pole and participations of {} references x {} poles, got {} x {}",
        references.column.cols(), start.size(), start_participation.rows(), start_participation.cols()));
  const Problem problem(tf, references, static_cast<long>(start.size()), options);
  if (problem.degrees_of_freedom() < 1)
    throw Error(fmt::format("fit_rank_one: {} modes need more lines than {}", start.size(), tf.lines()));
  State state = problem.evaluate(start, start_participation);
  const Outcome outcome = minimise(problem, options.max_iterations, options.tolerance, state);
  return problem.finish(state, outcome.converged);
}

PolePair split_pole(const TransferFunction& tf, const References& references, const std::vector<Pole>& poles,
                    long which, const PoleFitOptions& options) {
  const Lines lines(tf, options);
  const long count = static_cast<long>(poles.size());
  std::vector<long> used(static_cast<std::size_t>(2 * count));
  for (long i = 0; i < 2 * count; ++i) used[static_cast<std::size_t>(i)] = i;
  used.insert(used.end(), {2 * (count + which), 2 * (count + which) + 1});
  Eigen::VectorXcd c(static_cast<long>(lines.columns())), d = c;
  const auto products = lines.products(poles);
  for (std::size_t k = 0; k < products.size(); ++k) {
    const VectorXd solved = inverse_of(products[k].gram(used, used)) * products[k].against(used);
    c(static_cast<long>(k)) = Complex(solved(2 * which), solved(2 * which + 1));
    d(static_cast<long>(k)) = Complex(solved(2 * count), solved(2 * count + 1));
  }
  const MatrixXcd first = in_table(references, c), second = in_table(references, d);
  Eigen::JacobiSVD<MatrixXcd> svd(first, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const long rank = std::min<long>(2, svd.singularValues().size());
  MatrixXcd u = svd.matrixU().leftCols(rank), v = svd.matrixV().leftCols(rank);
  constexpr double flat = 0.02;  // of the first singular value: C alone does not tell the plane
  if (rank == 2 && svd.singularValues()(1) < flat * svd.singularValues()(0)) {
    MatrixXcd beside(first.rows(), 2 * first.cols()), below(2 * first.rows(), first.cols());
    beside << first, second;
    below << first, second;
    u = Eigen::JacobiSVD<MatrixXcd>(beside, Eigen::ComputeFullU).matrixU().leftCols(2);
    v = Eigen::JacobiSVD<MatrixXcd>(below, Eigen::ComputeFullV).matrixV().leftCols(2);
  }
  const Pole& pole = poles[static_cast<std::size_t>(which)];
  PolePair pair;
  if (rank < 2) {  // one output or one reference: shares are told by their poles alone
    pair.poles = {moved_by(pole, {0.25, 0.0}, options.damping),
                  moved_by(pole, {-0.25, 0.0}, options.damping)};
    pair.participation = v.conjugate().replicate(1, 2);
    return pair;
  }
  const MatrixXcd c2 = u.adjoint() * first * v, d2 = u.adjoint() * second * v;
  const Eigen::ComplexEigenSolver<MatrixXcd> eigen(
      MatrixXcd(d2 * c2.fullPivHouseholderQr().solve(MatrixXcd::Identity(2, 2))));
  const MatrixXcd along = eigen.eigenvectors().fullPivHouseholderQr().solve(c2 * v.adjoint());  // rows v_i^T
  for (long i = 0; i < 2; ++i) pair.poles.push_back(moved_by(pole, eigen.eigenvalues()(i), options.damping));
  pair.participation = along.transpose();
  return pair;
}

MatrixXcd dominant_participation(const References& references, const MatrixXcd& constant,
                                 const MatrixXd& sigma) {
  MatrixXcd participation(references.column.cols(), constant.rows());
  for (long r = 0; r < constant.rows(); ++r) {
    const double unit = sigma.row(r).mean();
    const MatrixXcd table = in_table(references, constant.row(r).transpose() / unit);
    const Eigen::JacobiSVD<MatrixXcd> svd(table, Eigen::ComputeFullV);
    participation.col(r) = svd.matrixV().col(0).conjugate();
  }
  return participation;
}

}  // namespace struna::ident
