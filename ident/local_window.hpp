#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "ident/local_model.hpp"

/// The algebra of one window of a local model (local_model.hpp), for several windows side by side.
namespace struna::ident::local {

inline constexpr long terms = 3;               ///< of N, T and D: degree two
inline constexpr long orders = 2 * terms - 1;  ///< powers of r in products of two of them
inline constexpr long count_orders = 9;        ///< of the lines alone: |D|^2 brings four more

/// Windows handled at once, by the processor's vector unit.
inline constexpr long lanes = 4;
using Pack = Eigen::Array<double, lanes, 1>;
using PackMap = Eigen::Map<Pack>;

/// Complex number whose product is four multiplications: the standard one's looks for infinities.
struct Z {
  Pack re = Pack::Zero();
  Pack im = Pack::Zero();
  Z operator+(const Z& b) const { return {re + b.re, im + b.im}; }
  Z operator-(const Z& b) const { return {re - b.re, im - b.im}; }
  Z operator-() const { return {-re, -im}; }
  Z operator*(const Z& b) const { return {re * b.re - im * b.im, re * b.im + im * b.re}; }
  Z operator*(const Pack& b) const { return {re * b, im * b}; }
  Z conj() const { return {re, -im}; }
  Pack norm() const { return re * re + im * im; }
};
using Vector = std::array<Z, terms>;
using Hermitian = std::array<Vector, terms>;  ///< [row][column], the lower triangle
using Real = std::array<std::array<Pack, terms>, terms>;

/// Sums over lines of 1, |X|^2, X, then for each output |Y|^2, Y, X* Y; complex ones as two numbers.
inline constexpr long input_channels = 4, output_channels = 5;
inline long line_channels(long outputs) {
  return input_channels + output_channels * outputs;
}

/// A window's sums after T is eliminated, added up over records: powers of r; for powers of r, the share that
/// T takes; |X|^2; the Gram matrix of the numerator's columns X r^a; for each output |Y|^2, the products of
/// those columns with r^j Y, the Gram matrix of r^j Y.
struct Layout {
  static constexpr long count = 0;
  static constexpr long transient = count + count_orders;
  static constexpr long input = transient + orders;
  static constexpr long gram = input + 1;
  static constexpr long shared = gram + terms * terms;
  static constexpr long cross = 1;  ///< within an output's part
  static constexpr long power = cross + 2 * terms * terms;
  static constexpr long per_output = power + terms * terms;
  static long of(long output) { return shared + output * per_output; }
  static long size(long outputs) { return of(outputs); }
};

/// Inverse of the positive definite Hankel matrix h_{a+b}.
struct HankelInverse {
  explicit HankelInverse(const std::array<Pack, count_orders>& h);
  /// tr(H^-1 K) for the Hankel matrix K of entries k[offset], k[offset + 1], ...
  Pack trace(const std::array<Pack, count_orders>& k, long offset) const;

  Real lower{};  ///< Cholesky factor; its diagonal inverted
  Real inverse{};
  std::array<Pack, orders> antidiagonal{};  ///< sums of the inverse
};

/// Adds windows of one record: `lines` (orders by channels, then count_orders) and the sums so far, `lanes`
/// numbers each.
void eliminate_transient(const double* lines, long outputs, double* sums);

/// The estimate in `lanes` windows.
class WindowFit {
 public:
  struct Estimate {
    Z value;
    Pack variance;     ///< E|error of H|^2: what noise brings through N and through D
    Pack noise_power;  ///< E|V|^2
  };
  WindowFit(const double* sums, long outputs, LocalForm form);

  bool usable(long lane) const { return usable_[lane]; }
  const Pack& input_power() const { return input_power_; }  ///< mean |X|^2
  const Estimate& estimate(long output) const { return estimate_[static_cast<std::size_t>(output)]; }

 private:
  struct Output {
    Hermitian power{};   ///< Gram matrix of r^j Y, N eliminated
    Vector numerator{};  ///< N(0) of r^j Y
    Pack noise = Pack::Ones();
    Pack least_noise = Pack::Ones();
  };
  void eliminate_numerator(const double* sums);
  void set_expected_noise(const double* sums);
  void weigh_outputs();
  void find_denominator();
  Hermitian weighted_power() const;
  Pack smallest_ratio(const Hermitian& power) const;
  void solve_denominator(const Hermitian& power, const Pack& bias, double prior);
  Pack centre_weight() const;
  void finish();

  long outputs_;
  Eigen::Array<bool, lanes, 1> usable_;
  Hermitian gram_{};  ///< Cholesky factor of the numerator's Gram matrix
  Vector row_{};      ///< first column of its inverse
  Pack input_power_;
  std::vector<Output> output_;
  std::vector<Estimate> estimate_;

  std::array<Pack, count_orders> count_{};
  std::array<Pack, orders> expected_{};  ///< of sum r^p |V|^2 after T and N, for noise of unit power
  Vector theta_{};                       ///< 1, d_1, d_2
  double taken_ = 0.0;                   ///< unknowns of D per output
  Pack mean_weight_ = Pack::Ones();      ///< mean |D|^2
  Pack covariance_11_ = Pack::Zero(), covariance_22_ = Pack::Zero();  ///< of d
  Z covariance_12_;
};

}  // namespace struna::ident::local
