#include "ident/local_window.hpp"

#include <limits>

namespace struna::ident::local {
namespace {

constexpr double prior_precision = 3.0;   // of d_1 and d_2
constexpr int weighings = 3;              // rounds: noise of each output, then D
constexpr int inverse_iterations = 3;     // towards the smallest ratio
constexpr double least_noise = 1e-20;     // of an output's power
constexpr double least_separable = 1e-6;  // of the input's power, T taken out
constexpr double least_pivot = 1e-12;     // of the diagonal entry
constexpr double least_definite = 1e-10;  // determinant over product of diagonal, once bias is taken off
constexpr double ridge = 1e-8;            // of the diagonal: common factors of N and D leave d undetermined

Pack at(const double* sums, long i) {
  return Eigen::Map<const Pack>(sums + lanes * i);
}
PackMap at(double* sums, long i) {
  return PackMap(sums + lanes * i);
}
Z complex_at(const double* sums, long i) {
  return {at(sums, i), at(sums, i + 1)};
}

/// Stored as the diagonal, then (1,0), (2,0), (2,1).
void add_hermitian(const Hermitian& m, double* sums, long first) {
  for (long i = 0; i < terms; ++i) at(sums, first + i) += m[i][i].re;
  for (long i = 1, k = first + terms; i < terms; ++i)
    for (long j = 0; j < i; ++j, k += 2) {
      at(sums, k) += m[i][j].re;
      at(sums, k + 1) += m[i][j].im;
    }
}
Hermitian hermitian_at(const double* sums, long first) {
  Hermitian m{};
  for (long i = 0; i < terms; ++i) m[i][i].re = at(sums, first + i);
  for (long i = 1, k = first + terms; i < terms; ++i)
    for (long j = 0; j < i; ++j, k += 2) m[i][j] = complex_at(sums, k);
  return m;
}

/// a^H b.
Z dot(const Vector& a, const Vector& b) {
  Z sum = a[0].conj() * b[0];
  for (long i = 1; i < terms; ++i) sum = sum + a[i].conj() * b[i];
  return sum;
}

/// theta^H M theta.
Pack form(const Hermitian& m, const Vector& theta) {
  Pack sum = Pack::Zero();
  for (long i = 0; i < terms; ++i) {
    sum += m[i][i].re * theta[i].norm();
    for (long j = 0; j < i; ++j) sum += 2.0 * (theta[i].conj() * m[i][j] * theta[j]).re;
  }
  return sum;
}
/// The same for a real Hankel matrix.
Pack form(const std::array<Pack, orders>& m, const Vector& theta) {
  Pack sum = Pack::Zero();
  for (long i = 0; i < terms; ++i) {
    sum += m[2 * i] * theta[i].norm();
    for (long j = 0; j < i; ++j) sum += 2.0 * m[i + j] * (theta[i].conj() * theta[j]).re;
  }
  return sum;
}

/// Lower Cholesky factor in place, its diagonal inverted; false where not positive definite to rounding.
Eigen::Array<bool, lanes, 1> factorise(Hermitian& m) {
  Eigen::Array<bool, lanes, 1> definite = Eigen::Array<bool, lanes, 1>::Constant(true);
  for (long j = 0; j < terms; ++j) {
    const Pack whole = m[j][j].re;
    Pack pivot = whole;
    for (long k = 0; k < j; ++k) pivot -= m[j][k].norm();
    definite = definite && pivot > least_pivot * whole;
    const Pack inverse = pivot.max(std::numeric_limits<double>::min()).rsqrt();
    m[j][j].re = inverse;
    for (long i = j + 1; i < terms; ++i) {
      for (long k = 0; k < j; ++k) m[i][j] = m[i][j] - m[i][k] * m[j][k].conj();
      m[i][j] = m[i][j] * inverse;
    }
  }
  return definite;
}

/// L^-1 b in place.
void solve_lower(const Hermitian& lower, Vector& b) {
  for (long i = 0; i < terms; ++i) {
    for (long k = 0; k < i; ++k) b[i] = b[i] - lower[i][k] * b[k];
    b[i] = b[i] * lower[i][i].re;
  }
}
void solve_lower(const Real& lower, Vector& b) {
  for (long i = 0; i < terms; ++i) {
    for (long k = 0; k < i; ++k) b[i] = b[i] - b[k] * lower[i][k];
    b[i] = b[i] * lower[i][i];
  }
}
/// L^-H b in place.
void solve_upper(const Hermitian& lower, Vector& b) {
  for (long i = terms; i-- > 0;) {
    for (long k = i + 1; k < terms; ++k) b[i] = b[i] - lower[k][i].conj() * b[k];
    b[i] = b[i] * lower[i][i].re;
  }
}

}  // namespace

HankelInverse::HankelInverse(const std::array<Pack, count_orders>& h) {
  for (long j = 0; j < terms; ++j)
    for (long i = j; i < terms; ++i) {
      Pack entry = h[i + j];
      for (long k = 0; k < j; ++k) entry -= lower[i][k] * lower[j][k];
      lower[i][j] = i == j ? Pack(entry.max(least_pivot * h[2 * i]).rsqrt()) : Pack(entry * lower[j][j]);
    }
  antidiagonal.fill(Pack::Zero());
  for (long j = 0; j < terms; ++j) {
    std::array<Pack, terms> column;
    column.fill(Pack::Zero());
    column[j].setOnes();
    for (long i = j; i < terms; ++i) {
      for (long k = j; k < i; ++k) column[i] -= lower[i][k] * column[k];
      column[i] *= lower[i][i];
    }
    for (long i = terms; i-- > 0;) {
      for (long k = i + 1; k < terms; ++k) column[i] -= lower[k][i] * column[k];
      column[i] *= lower[i][i];
      inverse[i][j] = column[i];
      antidiagonal[i + j] += column[i];
    }
  }
}

Pack HankelInverse::trace(const std::array<Pack, count_orders>& k, long offset) const {
  Pack sum = Pack::Zero();
  for (long s = 0; s < orders; ++s) sum += antidiagonal[s] * k[s + offset];
  return sum;
}

void eliminate_transient(const double* lines, long outputs, double* sums) {
  const long channels = line_channels(outputs);
  std::array<Pack, count_orders> count;
  for (long p = 0; p < count_orders; ++p) count[p] = at(lines, orders * channels + p);
  const HankelInverse powers(count);
  for (long p = 0; p < count_orders; ++p) at(sums, Layout::count + p) += count[p];
  for (long p = 0; p < orders; ++p) at(sums, Layout::transient + p) += powers.trace(count, p);
  at(sums, Layout::input) += at(lines, 1);

  // L^-1 P^H [r^j column], P the powers of r and P^H P = L L^T.
  const auto against_powers = [&](long channel) {
    std::array<Vector, terms> columns;
    for (long j = 0; j < terms; ++j) {
      for (long i = 0; i < terms; ++i) columns[j][i] = complex_at(lines, (i + j) * channels + channel);
      solve_lower(powers.lower, columns[j]);
    }
    return columns;
  };
  // sum r^(i+j) |column|^2 less what the powers take.
  const auto add_gram = [&](const std::array<Vector, terms>& columns, long channel, long first) {
    Hermitian gram{};
    for (long i = 0; i < terms; ++i)
      for (long j = 0; j <= i; ++j) {
        gram[i][j] = -dot(columns[i], columns[j]);
        gram[i][j].re += at(lines, (i + j) * channels + channel);
      }
    add_hermitian(gram, sums, first);
  };
  const auto input = against_powers(2);
  add_gram(input, 1, Layout::gram);
  for (long o = 0; o < outputs; ++o) {
    const long channel = input_channels + output_channels * o, mine = Layout::of(o);
    const auto output = against_powers(channel + 1);
    at(sums, mine) += at(lines, channel);
    for (long i = 0; i < terms; ++i)
      for (long j = 0; j < terms; ++j) {
        const Z cross = complex_at(lines, (i + j) * channels + channel + 3) - dot(input[i], output[j]);
        at(sums, mine + Layout::cross + 2 * (i * terms + j)) += cross.re;
        at(sums, mine + Layout::cross + 2 * (i * terms + j) + 1) += cross.im;
      }
    add_gram(output, channel, mine + Layout::power);
  }
}

WindowFit::WindowFit(const double* sums, long outputs, LocalForm form)
    : outputs_(outputs), output_(static_cast<std::size_t>(outputs)) {
  const Pack power = at(sums, Layout::input);
  gram_ = hermitian_at(sums, Layout::gram);
  usable_ = power > 0.0 && gram_[0][0].re > least_separable * power;
  usable_ = usable_ && factorise(gram_);
  if (!usable_.any()) return;
  for (long p = 0; p < count_orders; ++p) count_[p] = at(sums, Layout::count + p);
  input_power_ = power / count_[0];
  theta_[0].re.setOnes();
  eliminate_numerator(sums);
  set_expected_noise(sums);
  weigh_outputs();
  if (form == LocalForm::rational) find_denominator();
  finish();
}

void WindowFit::eliminate_numerator(const double* sums) {
  row_[0].re.setOnes();
  solve_lower(gram_, row_);
  for (long o = 0; o < outputs_; ++o) {
    Output& output = output_[static_cast<std::size_t>(o)];
    const long mine = Layout::of(o);
    output.power = hermitian_at(sums, mine + Layout::power);
    output.least_noise = (least_noise * at(sums, mine)).max(std::numeric_limits<double>::min());
    std::array<Vector, terms> columns;
    for (long j = 0; j < terms; ++j) {
      for (long i = 0; i < terms; ++i)
        columns[j][i] = complex_at(sums, mine + Layout::cross + 2 * (i * terms + j));
      solve_lower(gram_, columns[j]);
      output.numerator[j] = dot(row_, columns[j]);
      for (long i = 0; i <= j; ++i) output.power[j][i] = output.power[j][i] - dot(columns[j], columns[i]);
    }
  }
}

/// Lines less what T and N take of them; for N as if |X|^2 were the same on all lines.
void WindowFit::set_expected_noise(const double* sums) {
  const HankelInverse powers(count_);
  for (long p = 0; p < orders; ++p)
    expected_[p] = count_[p] - at(sums, Layout::transient + p) - powers.trace(count_, p);
}

void WindowFit::weigh_outputs() {
  const Pack weight = form(expected_, theta_);
  mean_weight_ = weight / expected_[0];
  for (Output& output : output_) output.noise = form(output.power, theta_).max(output.least_noise) / weight;
}

/// Sum over outputs of their Gram matrices, each over its noise, and over the number of outputs.
Hermitian WindowFit::weighted_power() const {
  Hermitian sum{};
  for (const Output& output : output_) {
    const Pack weight = 1.0 / (static_cast<double>(outputs_) * output.noise);
    for (long i = 0; i < terms; ++i)
      for (long j = 0; j <= i; ++j) sum[i][j] = sum[i][j] + output.power[i][j] * weight;
  }
  return sum;
}

void WindowFit::find_denominator() {
  taken_ = 2.0 / static_cast<double>(outputs_);
  for (int round = 0; round < weighings; ++round) {
    const Hermitian power = weighted_power();
    const Pack ratio = smallest_ratio(power);
    // The first round's noise is that of the polynomial, which near a pole is no noise: no prior against it.
    const double prior = round == 0 ? 0.0 : prior_precision / static_cast<double>(outputs_);
    solve_denominator(power, ratio * (1.0 - taken_ / expected_[0]), prior);
    weigh_outputs();
  }
}

/// Least theta^H A theta/theta^H M theta, M the expected noise, by inverse iteration; 0 where A is singular.
Pack WindowFit::smallest_ratio(const Hermitian& power) const {
  Hermitian factor = power;
  const auto definite = factorise(factor);
  Vector theta = theta_;
  Pack ratio = Pack::Zero();
  for (int iteration = 0; iteration < inverse_iterations; ++iteration) {
    Vector next;
    for (long i = 0; i < terms; ++i) {
      next[i] = Z{};
      for (long j = 0; j < terms; ++j) next[i] = next[i] + theta[j] * expected_[i + j];
    }
    solve_lower(factor, next);
    solve_upper(factor, next);
    ratio = form(power, next) / form(expected_, next);
    const Pack size = (next[0].norm() + next[1].norm() + next[2].norm()).rsqrt();
    for (long i = 0; i < terms; ++i) theta[i] = next[i] * size;
  }
  return definite.select(ratio, 0.0);
}

/// The d that makes theta^H (A - bias M) theta + prior |d|^2 least. Bias beyond what leaves the matrix
/// definite (the ratio's iteration ends above the least) is not taken off.
void WindowFit::solve_denominator(const Hermitian& power, const Pack& bias, double prior) {
  Pack taken = bias, h11, h22, determinant;
  Z h21, g1, g2;
  for (int attempt = 0; attempt < 3; ++attempt) {
    h11 = (1.0 + ridge) * power[1][1].re - taken * expected_[2] + prior;
    h22 = (1.0 + ridge) * power[2][2].re - taken * expected_[4] + prior;
    h21 = power[2][1];
    h21.re -= taken * expected_[3];
    determinant = h11 * h22 - h21.norm();
    // With A - bias M positive semidefinite, the prior is the least that both eigenvalues can be.
    const Pack least = (least_definite * power[1][1].re * power[2][2].re).max(prior * prior);
    const auto definite = (h11 > prior && h22 > prior && determinant > least).eval();
    if (definite.all()) break;
    taken = definite.select(taken, attempt == 0 ? Pack(0.8 * taken) : Pack(Pack::Zero()));
  }
  g1 = power[1][0];
  g2 = power[2][0];
  g1.re -= taken * expected_[1];
  g2.re -= taken * expected_[2];
  covariance_11_ = h22 / determinant;
  covariance_22_ = h11 / determinant;
  covariance_12_ = -h21.conj() * Pack(1.0 / determinant);
  theta_[1] = -(g1 * covariance_11_ + covariance_12_ * g2);
  theta_[2] = -(covariance_12_.conj() * g1 + g2 * covariance_22_);
}

void WindowFit::finish() {
  const Pack leverage = (row_[0].norm() + row_[1].norm() + row_[2].norm()) * centre_weight();
  const Pack free_share = 1.0 - taken_ / expected_[0];
  const Pack scale = mean_weight_ / (static_cast<double>(outputs_) * free_share);
  for (const Output& output : output_) {
    const Vector& n = output.numerator;
    const Pack through_d = covariance_11_ * n[1].norm() + covariance_22_ * n[2].norm() +
                           2.0 * (n[1] * covariance_12_ * n[2].conj()).re;
    const Pack noise = output.noise / free_share;
    const Pack variance = noise * leverage + through_d * scale;
    // Sums without any noise, as simulated ones, may round to less than nothing, or to nothing that tells D.
    estimate_.push_back(
        {n[0] + n[1] * theta_[1] + n[2] * theta_[2], (variance > 0.0).select(variance, 0.0), noise});
    const Z& value = estimate_.back().value;
    usable_ = usable_ && (value.re + value.im).isFinite();
  }
}

/// Mean of |D|^2 under the weights that N(0) gives to the lines, as if |X|^2 were the same on all.
Pack WindowFit::centre_weight() const {
  const HankelInverse powers(count_);
  const Pack d1 = theta_[1].norm(), d2 = theta_[2].norm();
  const std::array<Pack, orders> square = {Pack::Ones(), 2.0 * theta_[1].re, d1 + 2.0 * theta_[2].re,
                                           2.0 * (theta_[1].conj() * theta_[2]).re, d2};
  Pack sum = Pack::Zero();
  for (long p = 0; p < orders; ++p)
    for (long a = 0; a < terms; ++a)
      for (long b = 0; b < terms; ++b)
        sum += powers.inverse[a][0] * powers.inverse[b][0] * square[p] * count_[a + b + p];
  return sum / powers.inverse[0][0];
}

}  // namespace struna::ident::local
