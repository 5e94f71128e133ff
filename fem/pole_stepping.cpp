#include "fem/pole_stepping.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "fem/quadrature.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;

/// Product without the checks for infinities that the standard asks of operator*.
Complex times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

constexpr double reciprocal[] = {0.0,     1.0,     1.0 / 2, 1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,
                                 1.0 / 7, 1.0 / 8, 1.0 / 9, 1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13};

/// (e^x - 1)/x and ((e^x - 1)/x - 1)/x: by their series near zero, where the quotients would cancel.
struct Phi {
  Complex exponential, one, two;
};

Phi phi_functions(Complex x, Complex inverse) {
  constexpr double series_radius = 0.3;  // twelve terms leave 0.3^13/14! < 1e-17
  if (std::abs(x.real()) + std::abs(x.imag()) > series_radius) {
    const double size = std::exp(x.real());
    const Complex exponential(size * std::cos(x.imag()), size * std::sin(x.imag()));
    const Complex one = times(exponential - 1.0, inverse);
    return {exponential, one, times(one - 1.0, inverse)};
  }
  Complex two = 0.0;
  for (int n = 13; n >= 2; --n) two = (1.0 + times(two, x)) * reciprocal[n];
  // two = 1/2 + x/6 + x^2/24 + ..., and one = 1 + x two.
  const Complex one = 1.0 + times(x, two);
  return {1.0 + times(x, one), one, two};
}

double real_phi_one(double x) {
  return std::abs(x) < 1e-300 ? 1.0 : std::expm1(x) / x;
}

/// exp(x), (e^x - 1)/x and so on: phi_{n+1} = (phi_n - 1/n!)/x, by the series where that would cancel.
struct RealPhi {
  double exponential, one, two, three;
};

RealPhi real_phi(double x) {
  if (std::abs(x) > 0.3) {
    const double one = std::expm1(x) / x;
    const double two = (one - 1.0) / x;
    return {std::exp(x), one, two, (two - 0.5) / x};
  }
  double three = 0.0;  // 1/6 + x/24 + x^2/120 + ...
  for (int n = 13; n >= 4; --n) three = (1.0 + three * x) * reciprocal[n];
  three = (1.0 + three * x) * reciprocal[2] * reciprocal[3];
  const double two = 0.5 + x * three;
  const double one = 1.0 + x * two;
  return {1.0 + x * one, one, two, three};
}

int pole_end(const PoleArrays& poles, int begin) {
  int end = begin + 1;
  while (end < poles.size() && poles.mode[end] == poles.mode[begin]) ++end;
  return end;
}

Complex at(const Eigen::ArrayXd& re, const Eigen::ArrayXd& im, int k) {
  return {re[k], im[k]};
}

StepCoefficients::RealPair real_pair_integrals(double mu_one, double mu_two, double h) {
  const auto integral = [h](double mu) { return h * real_phi_one(mu * h); };
  return {integral(mu_one), integral(mu_two), integral(2.0 * mu_one), integral(mu_one + mu_two),
          integral(2.0 * mu_two)};
}

/// Integral of q'^2 over the step for a mode with two real poles: q' = w1 + w2, w_k = A_k exp(mu_k t) -
/// kappa_k.
double real_pair_velocity_square(const PoleArrays& poles, int k, const StepCoefficients::RealPair& integral,
                                 double step, double load_start, double slope, const PoleState& from) {
  const double kappa_one = poles.ratio_re[k] * slope / step;
  const double kappa_two = poles.ratio_re[k + 1] * slope / step;
  const double one = poles.re[k] * from.re[k] + poles.residue_re[k] * load_start + kappa_one;
  const double two = poles.re[k + 1] * from.re[k + 1] + poles.residue_re[k + 1] * load_start + kappa_two;
  const double kappa = kappa_one + kappa_two;
  return one * one * integral.one_one + 2.0 * one * two * integral.one_two + two * two * integral.two_two -
         2.0 * kappa * (one * integral.one + two * integral.two) + kappa * kappa * step;
}

}  // namespace

void set_step(const PoleArrays& poles, double step, StepCoefficients& c) {
  const int n = poles.size();
  c.step = step;
  for (Eigen::ArrayXd* array : {&c.e_re, &c.e_im, &c.a_re, &c.a_im, &c.b_re, &c.b_im}) array->resize(n);
  c.flexibility.setZero(poles.modes);
  c.with_energy = false;
  for (int k = poles.elastic; k < n; ++k) {
    const RealPhi phi = real_phi(poles.re[k] * step);
    c.e_re[k] = step * phi.one;
    c.e_im[k] = phi.exponential;
    c.a_re[k] = step * step * phi.two;
    c.a_im[k] = step * phi.one;
    c.b_re[k] = step * step * (phi.three - 0.5 * phi.two);
    c.b_im[k] = step * (phi.two - 0.5 * phi.one);
    c.flexibility[poles.mode[k]] = c.a_re[k];
  }
  for (int k = 0; k < poles.elastic; ++k) {
    const Phi phi =
        phi_functions(step * at(poles.re, poles.im, k), at(poles.inverse_re, poles.inverse_im, k) / step);
    const Complex residue = step * at(poles.residue_re, poles.residue_im, k);
    const Complex a = times(residue, phi.one);
    const Complex b = times(residue, phi.two - 0.5 * phi.one);
    c.e_re[k] = phi.exponential.real();
    c.e_im[k] = phi.exponential.imag();
    c.a_re[k] = a.real();
    c.a_im[k] = a.imag();
    c.b_re[k] = b.real();
    c.b_im[k] = b.imag();
    c.flexibility[poles.mode[k]] += a.real();
  }
}

void set_energy(const PoleArrays& poles, StepCoefficients& c) {
  if (c.with_energy) return;
  c.with_energy = true;
  for (Eigen::ArrayXd* array : {&c.int_re, &c.int_im, &c.int_abs2, &c.int_square_re, &c.int_square_im}) {
    array->resize(poles.single);
  }
  for (int k = 0; k < poles.single; ++k) {
    // a = r I: the integral I of exp(mu t) is a/r.
    const Complex residue = at(poles.residue_re, poles.residue_im, k);
    const Complex integral = times(at(c.a_re, c.a_im, k), std::conj(residue)) / std::norm(residue);
    const Complex square = times(integral, 0.5 * (at(c.e_re, c.e_im, k) + 1.0));
    c.int_re[k] = integral.real();
    c.int_im[k] = integral.imag();
    c.int_abs2[k] = c.step * real_phi_one(2.0 * poles.re[k] * c.step);
    c.int_square_re[k] = square.real();
    c.int_square_im[k] = square.imag();
  }
  c.real_pair.clear();
  for (const int k : poles.real_pair) {
    c.real_pair.push_back(real_pair_integrals(poles.re[k], poles.re[k + 1], c.step));
  }
}

void propagate(const PoleArrays& poles, const StepCoefficients& c, const Eigen::ArrayXd& mean,
               const Eigen::ArrayXd& slope, const PoleState& from, PoleState& to) {
  const int n = poles.single;
  to.re.head(n) = c.e_re.head(n) * from.re.head(n) - c.e_im.head(n) * from.im.head(n) +
                  c.a_re.head(n) * mean.head(n) + c.b_re.head(n) * slope.head(n);
  to.im.head(n) = c.e_im.head(n) * from.re.head(n) + c.e_re.head(n) * from.im.head(n) +
                  c.a_im.head(n) * mean.head(n) + c.b_im.head(n) * slope.head(n);
  for (int k = n; k < poles.size(); ++k) {
    const int m = poles.mode[k];
    const bool rigid = k >= poles.elastic;
    const double e_re =
        rigid ? from.re[k] + c.e_re[k] * from.im[k] : c.e_re[k] * from.re[k] - c.e_im[k] * from.im[k];
    const double e_im = rigid ? c.e_im[k] * from.im[k] : c.e_im[k] * from.re[k] + c.e_re[k] * from.im[k];
    to.re[k] = e_re + c.a_re[k] * mean[m] + c.b_re[k] * slope[m];
    to.im[k] = e_im + c.a_im[k] * mean[m] + c.b_im[k] * slope[m];
  }
}

void add_constant_load(const PoleArrays& poles, const StepCoefficients& c, const Eigen::ArrayXd& load,
                       PoleState& to) {
  const int n = poles.single;
  to.re.head(n) += c.a_re.head(n) * load.head(n);
  to.im.head(n) += c.a_im.head(n) * load.head(n);
  for (int k = n; k < poles.size(); ++k) {
    to.re[k] += c.a_re[k] * load[poles.mode[k]];
    to.im[k] += c.a_im[k] * load[poles.mode[k]];
  }
}

void modal_displacement(const PoleArrays& poles, const PoleState& state, Eigen::VectorXd& q) {
  q.head(poles.single) = state.re.head(poles.single);
  q.tail(poles.modes - poles.single).setZero();
  for (int k = poles.single; k < poles.size(); ++k) q[poles.mode[k]] += state.re[k];
}

void modal_velocity(const PoleArrays& poles, const PoleState& state, Eigen::VectorXd& v) {
  const int n = poles.single;
  v.head(n) = poles.re.head(n) * state.re.head(n) - poles.im.head(n) * state.im.head(n);
  v.tail(poles.modes - n).setZero();
  for (int k = n; k < poles.elastic; ++k) {
    v[poles.mode[k]] += poles.re[k] * state.re[k] - poles.im[k] * state.im[k];
  }
  for (int k = poles.elastic; k < poles.size(); ++k) v[poles.mode[k]] = state.im[k];
}

void modal_internal_force(const PoleArrays& poles, const PoleState& state, Eigen::VectorXd& force) {
  force.setZero(poles.modes);
  for (int k = 0; k < poles.elastic; ++k) {
    const Complex mu = at(poles.re, poles.im, k);
    force[poles.mode[k]] -= (mu * mu * at(state.re, state.im, k)).real();
  }
  for (int k = poles.elastic; k < poles.size(); ++k) force[poles.mode[k]] = -poles.re[k] * state.im[k];
}

namespace {

double velocity_of(const PoleArrays& poles, const PoleState& state, int begin, int end) {
  double v = 0.0;
  for (int k = begin; k < end; ++k) v += poles.re[k] * state.re[k] - poles.im[k] * state.im[k];
  return v;
}

/// Modes of one pole: with w = mu z + r p, q' = Re w and w = (w0 + kappa) exp(mu t) - kappa, kappa = r
/// slope/(mu h), the integral of q'^2 is half of (|A|^2 I_abs + Re(A^2 I_square) - 4 Re(kappa) Re(A I) + 2
/// Re(kappa)^2 h), A = w0 + kappa. In blocks, on the stack, in real arithmetic: this runs at every step.
StepEnergy single_pole_energy(const PoleArrays& poles, const StepCoefficients& c, const Eigen::ArrayXd& mean,
                              const Eigen::ArrayXd& slope, const Eigen::ArrayXd& contact,
                              const PoleState& from, const PoleState& to) {
  constexpr int block = 64;
  using Block = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, block, 1>;
  StepEnergy energy;
  const double h = c.step;
  for (int at = 0; at < poles.single; at += block) {
    const int n = std::min(block, poles.single - at);
    const auto part = [&](const Eigen::ArrayXd& array) { return array.segment(at, n); };
    const Block q0 = part(from.re);
    const Block gain_re = part(to.re) - q0;
    const Block gain_im = part(to.im) - part(from.im);
    const Block s = part(slope);
    const Block total = part(mean) + part(contact);
    // Mean of q over the step, from z' = mu z + r p integrated.
    const Block q_mean = (part(poles.inverse_re) * gain_re - part(poles.inverse_im) * gain_im) / h -
                         part(poles.ratio_re) * total;
    energy.load_work += (part(mean) * gain_re + s * (q0 + 0.5 * gain_re - q_mean)).sum();
    const Block load = total - 0.5 * s;
    const Block kappa = part(poles.ratio_re) * s / h;
    const Block a =
        part(poles.re) * q0 - part(poles.im) * part(from.im) + part(poles.residue_re) * load + kappa;
    const Block b = part(poles.re) * part(from.im) + part(poles.im) * q0 + part(poles.residue_im) * load +
                    part(poles.ratio_im) * s / h;
    const Block square = (a * a + b * b) * part(c.int_abs2) + (a * a - b * b) * part(c.int_square_re) -
                         2.0 * a * b * part(c.int_square_im) -
                         4.0 * kappa * (a * part(c.int_re) - b * part(c.int_im)) + 2.0 * h * kappa * kappa;
    energy.dissipated -= (part(poles.re) * square).sum();
  }
  return energy;
}

/// A rigid mode by Gauss's rule on q': exact without drag, where q' is a parabola, and to rounding with it (6
/// points where its exponential squared falls by e at most).
void add_rigid_energy(const PoleArrays& poles, const StepCoefficients& c, int k, double mean, double slope,
                      double contact, const PoleState& from, const PoleState& to, StepEnergy& energy) {
  static const GaussRule rule = gauss_legendre(6);
  const double h = c.step;
  const double mu = poles.re[k];
  const double load_start = mean + contact - 0.5 * slope;
  const int panels = 1 + static_cast<int>(-2.0 * mu * h);
  double moment = 0.0, square = 0.0;  // integrals of (t/h - 1/2) q' and of q'^2
  for (int panel = 0; panel < panels; ++panel) {
    for (Eigen::Index i = 0; i < rule.node.size(); ++i) {
      const double part = (panel + rule.node[i]) / panels;
      const double t = part * h;
      const RealPhi phi = real_phi(mu * t);
      const double v = phi.exponential * from.im[k] + t * (phi.one * load_start + part * phi.two * slope);
      const double weight = rule.weight[i] * h / panels;
      moment += weight * (part - 0.5) * v;
      square += weight * v * v;
    }
  }
  energy.load_work += mean * (to.re[k] - from.re[k]) + slope * moment;
  energy.dissipated -= mu * square;
}

}  // namespace

StepEnergy step_energy(const PoleArrays& poles, const StepCoefficients& c, const Eigen::ArrayXd& mean,
                       const Eigen::ArrayXd& slope, const Eigen::ArrayXd& contact, const PoleState& from,
                       const PoleState& to) {
  StepEnergy energy = single_pole_energy(poles, c, mean, slope, contact, from, to);
  const double h = c.step;
  std::size_t pair = 0;
  for (int k = poles.elastic; k < poles.size(); ++k) {
    const int m = poles.mode[k];
    add_rigid_energy(poles, c, k, mean[m], slope[m], contact[m], from, to, energy);
  }
  for (int k = poles.single; k < poles.elastic;) {
    const int end = pole_end(poles, k);
    const int m = poles.mode[k];
    const double total = mean[m] + contact[m];
    double gain = 0.0, q0 = 0.0, average = 0.0;
    for (int j = k; j < end; ++j) {
      const double gain_re = to.re[j] - from.re[j];
      q0 += from.re[j];
      gain += gain_re;
      average += (poles.inverse_re[j] * gain_re - poles.inverse_im[j] * (to.im[j] - from.im[j])) / h -
                 poles.ratio_re[j] * total;
    }
    const double work = mean[m] * gain + slope[m] * (q0 + 0.5 * gain - average);
    energy.load_work += work;
    if (pair < poles.real_pair.size() && poles.real_pair[pair] == k) {
      energy.dissipated -=
          (poles.re[k] + poles.re[k + 1]) *
          real_pair_velocity_square(poles, k, c.real_pair[pair], h, total - 0.5 * slope[m], slope[m], from);
      ++pair;
    } else {
      const double v0 = velocity_of(poles, from, k, end);
      const double v1 = velocity_of(poles, to, k, end);
      energy.internal_work += work + contact[m] * gain - 0.5 * (v1 * v1 - v0 * v0);
    }
    k = end;
  }
  return energy;
}

}  // namespace struna::fem
