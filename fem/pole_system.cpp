#include "fem/pole_system.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;
constexpr double two_pi = 2.0 * std::numbers::pi;

/// min |A x - b|, x >= 0: Lawson & Hanson, algorithm NNLS (23.10).
Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const long n = a.cols();
  const double zero = 1e-10 * (a.transpose() * b).cwiseAbs().maxCoeff();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<bool> passive(static_cast<std::size_t>(n), false);
  const auto solve_passive = [&] {
    std::vector<int> set;
    for (int j = 0; j < n; ++j) {
      if (passive[static_cast<std::size_t>(j)]) set.push_back(j);
    }
    Eigen::VectorXd z = Eigen::VectorXd::Zero(n);
    const Eigen::MatrixXd columns = a(Eigen::all, set);
    z(set) = columns.colPivHouseholderQr().solve(b);
    return z;
  };
  for (long pass = 0; pass < 3 * n; ++pass) {
    const Eigen::VectorXd gradient = a.transpose() * (b - a * x);
    long best = -1;
    for (long j = 0; j < n; ++j) {
      const bool candidate = !passive[static_cast<std::size_t>(j)] && gradient[j] > zero;
      if (candidate && (best < 0 || gradient[j] > gradient[best])) best = j;
    }
    if (best < 0) break;
    passive[static_cast<std::size_t>(best)] = true;
    Eigen::VectorXd z = solve_passive();
    for (;;) {  // back to the feasible side, dropping what reaches zero
      double step = 1.0;
      for (long j = 0; j < n; ++j) {
        if (passive[static_cast<std::size_t>(j)] && z[j] <= 0.0) step = std::min(step, x[j] / (x[j] - z[j]));
      }
      x += step * (z - x);
      if (step >= 1.0) break;
      for (long j = 0; j < n; ++j) {
        if (passive[static_cast<std::size_t>(j)] && z[j] <= 0.0 && x[j] <= 1e-14 * x.maxCoeff()) {
          passive[static_cast<std::size_t>(j)] = false;
          x[j] = 0.0;
        }
      }
      z = solve_passive();
    }
  }
  return x;
}

/// Relaxation times per decade: the ripple this leaves in a power law is below 3e-4 of the modulus.
constexpr double times_per_decade = 1.5;
/// How far they reach beyond the band on either side.
constexpr double time_margin = 3.0;

/// Making a law exact at one frequency leaves its relaxed spring at least this share of the modulus.
constexpr double least_relaxed = 0.1;

struct ModePoles {
  std::vector<Complex> pole;
  std::vector<Complex> residue;
};

/// s^2 + c s + w^2. Where the two poles (nearly) coincide the discriminant is moved off zero: the response is
/// an even, smooth function of it, so a shift of 1e-9 relative shows only there, while the residues stay
/// finite.
ModePoles viscous_poles(double omega, double c) {
  const double scale = std::max(omega, 0.5 * c);
  double discriminant = omega * omega - 0.25 * c * c;
  if (std::abs(discriminant) < 1e-9 * scale * scale) discriminant = 1e-9 * scale * scale;
  if (discriminant > 0.0) {
    const double damped = std::sqrt(discriminant);
    return {{Complex(-0.5 * c, damped)}, {Complex(0.0, -1.0 / damped)}};
  }
  const double root = std::sqrt(-discriminant);
  const double fast = -0.5 * c - root;
  const double slow = omega * omega / fast;  // product of the poles, free of cancellation
  return {{slow, fast}, {1.0 / (slow - fast), 1.0 / (fast - slow)}};
}

/// Zeros of s^2 + lambda E*(s): eigenvalues of the mode with its internal variables x_j, tau_j x_j' = q -
/// x_j, then Newton.
ModePoles viscoelastic_poles(double eigenvalue, const MaxwellLaw& law) {
  const long memory = law.strength.size();
  const double omega = std::sqrt(eigenvalue * (law.relaxed + law.strength.sum()));  // scale of time
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(memory + 2, memory + 2);
  const double unit = eigenvalue / (omega * omega);
  a(0, 1) = 1.0;
  a(1, 0) = -unit * (law.relaxed + law.strength.sum());
  a(1, 1) = -unit * law.viscosity * omega;
  for (long j = 0; j < memory; ++j) {
    const double rate = 1.0 / (law.relaxation_time[j] * omega);
    a(1, j + 2) = unit * law.strength[j];
    a(j + 2, 0) = rate;
    a(j + 2, j + 2) = -rate;
  }
  const Eigen::VectorXcd start = omega * a.eigenvalues();
  ModePoles poles;
  for (Complex s : start) {
    if (s.imag() < 0.0) continue;
    for (int pass = 0; pass < 3; ++pass) {
      s -= (s * s + eigenvalue * law.at(s)) / (2.0 * s + eigenvalue * law.derivative(s));
    }
    const Complex residue = 1.0 / (2.0 * s + eigenvalue * law.derivative(s));
    poles.pole.push_back(s);
    poles.residue.push_back(s.imag() > 0.0 ? 2.0 * residue : residue);
  }
  return poles;
}

}  // namespace

Complex MaxwellLaw::at(Complex s) const {
  Complex sum = relaxed + viscosity * s;
  for (long j = 0; j < strength.size(); ++j) {
    const Complex u = s * relaxation_time[j];
    sum += strength[j] * u / (1.0 + u);
  }
  return sum;
}

Complex MaxwellLaw::derivative(Complex s) const {
  Complex sum = viscosity;
  for (long j = 0; j < strength.size(); ++j) {
    const Complex one = 1.0 + s * relaxation_time[j];
    sum += strength[j] * relaxation_time[j] / (one * one);
  }
  return sum;
}

MaxwellLaw fit_maxwell_law(const FrequencyLaw& youngs_modulus, const FrequencyLaw& loss_factor, double lo_hz,
                           double hi_hz) {
  if (!(lo_hz > 0.0 && hi_hz > lo_hz && std::isfinite(hi_hz))) {
    throw Error(fmt::format("fit_maxwell_law: the band must rise from above zero, got {:g} to {:g} Hz", lo_hz,
                            hi_hz));
  }
  const double decades = std::log10(hi_hz / lo_hz * time_margin * time_margin);
  const auto memory = static_cast<long>(std::ceil(decades * times_per_decade)) + 1;
  const long lines = 20 * static_cast<long>(std::ceil(decades));
  Eigen::VectorXd tau(memory);
  for (long j = 0; j < memory; ++j) {
    const double at = static_cast<double>(j) / static_cast<double>(memory - 1);
    tau[j] = std::pow(10.0, decades * at) / (two_pi * hi_hz * time_margin);
  }
  Eigen::MatrixXd a(2 * lines, memory + 2);
  Eigen::VectorXd b(2 * lines);
  for (long i = 0; i < lines; ++i) {
    const double f = lo_hz * std::pow(hi_hz / lo_hz, static_cast<double>(i) / static_cast<double>(lines - 1));
    const double eta = loss_factor.at(f);
    const double size = youngs_modulus.at(f) * std::hypot(1.0, eta);
    const auto put = [&](long column, Complex value) {
      a(i, column) = value.real() / size;
      a(lines + i, column) = value.imag() / size;
    };
    put(0, 1.0);
    put(1, Complex(0.0, f / hi_hz));
    for (long j = 0; j < memory; ++j) {
      const Complex u(0.0, two_pi * f * tau[j]);
      put(j + 2, u / (1.0 + u));
    }
    b[i] = 1.0 / std::hypot(1.0, eta);
    b[lines + i] = eta / std::hypot(1.0, eta);
  }
  const Eigen::VectorXd column_scale = a.colwise().norm();
  const Eigen::VectorXd x =
      non_negative_least_squares(a * column_scale.cwiseInverse().asDiagonal(), b).cwiseQuotient(column_scale);
  std::vector<long> used;
  for (long j = 0; j < memory; ++j) {
    if (x[j + 2] > 1e-9 * x[0]) used.push_back(j);
  }
  return {x[0], tau(used), x.tail(memory)(used), x[1] / (two_pi * hi_hz)};
}

MaxwellLaw exact_at(const MaxwellLaw& law, double youngs_modulus, double loss_factor, double f_hz,
                    double fitted_to_hz) {
  if (!(youngs_modulus > 0.0 && loss_factor >= 0.0 && f_hz > 0.0 && std::isfinite(youngs_modulus) &&
        std::isfinite(loss_factor) && std::isfinite(f_hz))) {
    throw Error(
        fmt::format("exact_at: E and f must be positive and eta at least 0, got {:g} Pa, {:g} Hz, {:g}",
                    youngs_modulus, f_hz, loss_factor));
  }
  const double omega = two_pi * f_hz;
  const double loss = youngs_modulus * loss_factor;
  const Complex memory = law.at(Complex(0.0, omega)) - law.relaxed;
  // Above the fitted band the memory's loss falls like 1/f: it is scaled as at the band's edge, and what is
  // missing the dashpot gives.
  const double fitted = law.at(Complex(0.0, two_pi * std::min(f_hz, fitted_to_hz))).imag();
  double scale = fitted > 0.0 ? loss / fitted : 0.0;
  if (memory.imag() > 0.0) scale = std::min(scale, loss / memory.imag());
  if (memory.real() > 0.0) {
    scale = std::min(scale, (1.0 - least_relaxed) * youngs_modulus / memory.real());
  }
  MaxwellLaw exact = law;
  exact.strength *= scale;
  exact.viscosity = scale * law.viscosity + std::max(0.0, loss - scale * memory.imag()) / omega;
  exact.relaxed = youngs_modulus - scale * memory.real();
  return exact;
}

PoleSystem pole_system(const Model& model, const Eigenmodes& modes, Damping damping, double band_hi_hz) {
  const Material& material = model.body.material;
  PoleSystem system;
  system.modes = static_cast<int>(modes.eigenvalue.size());
  system.natural_frequency_hz = Eigen::VectorXd::Zero(system.modes);
  system.relaxed_stiffness = Eigen::VectorXd::Zero(system.modes);
  system.rest_stiffness = Eigen::VectorXd::Zero(system.modes);
  double lowest_hz = std::numeric_limits<double>::infinity();
  for (int m = 0; m < system.modes; ++m) {
    if (is_rigid(model.body, modes.eigenvalue[m])) continue;
    system.natural_frequency_hz[m] = natural_frequency_hz(modes.eigenvalue[m], material.youngs_modulus);
    lowest_hz = std::min(lowest_hz, system.natural_frequency_hz[m]);
  }
  if (!std::isfinite(lowest_hz)) lowest_hz = band_hi_hz;
  const double fitted_to_hz = std::max(lowest_hz, band_hi_hz);
  const bool structural = damping == Damping::structural;
  if (structural) {
    system.law = fit_maxwell_law(material.youngs_modulus, material.loss_factor,
                                 std::min(lowest_hz, band_hi_hz) / 3.0, fitted_to_hz);
  } else {
    system.law.relaxed = material.youngs_modulus.at(lowest_hz);
    system.law.viscosity = material.rayleigh.beta * system.law.relaxed;
  }
  const double rest_modulus =
      material.youngs_modulus.at(rest_frequency_hz(material.youngs_modulus, lowest_hz));
  std::vector<Complex> pole, residue;
  std::vector<int> owner;
  for (int m = 0; m < system.modes; ++m) {
    const double f = system.natural_frequency_hz[m];
    const double omega = two_pi * f;
    if (f > 0.0) system.rest_stiffness[m] = modes.eigenvalue[m] * rest_modulus;
    ModePoles found;
    if (structural && f > 0.0) {
      const auto law =
          exact_at(system.law, material.youngs_modulus.at(f), material.loss_factor.at(f), f, fitted_to_hz);
      found = viscoelastic_poles(modes.eigenvalue[m], law);
      system.relaxed_stiffness[m] = modes.eigenvalue[m] * law.relaxed;
    } else if (f == 0.0) {
      found = {{structural ? 0.0 : -material.rayleigh.alpha}, {1.0}};
    } else {
      const Rayleigh& rayleigh = material.rayleigh;
      found = viscous_poles(omega, rayleigh.alpha + rayleigh.beta * omega * omega);
      system.relaxed_stiffness[m] = omega * omega;
    }
    pole.insert(pole.end(), found.pole.begin(), found.pole.end());
    residue.insert(residue.end(), found.residue.begin(), found.residue.end());
    owner.insert(owner.end(), found.pole.size(), m);
  }
  system.pole = Eigen::Map<Eigen::VectorXcd>(pole.data(), static_cast<long>(pole.size()));
  system.residue = Eigen::Map<Eigen::VectorXcd>(residue.data(), static_cast<long>(residue.size()));
  system.mode = Eigen::Map<Eigen::VectorXi>(owner.data(), static_cast<long>(owner.size()));
  return system;
}

double rest_frequency_hz(const FrequencyLaw& youngs_modulus, double lowest_natural_hz) {
  if (youngs_modulus.valid_from_hz > 0.0) return youngs_modulus.valid_from_hz;
  if (!youngs_modulus.frequency.empty() && youngs_modulus.frequency.front() > 0.0) {
    return youngs_modulus.frequency.front();
  }
  return lowest_natural_hz;
}

bool is_rigid_pole(const PoleSystem& system, int begin, int end) {
  return end - begin == 1 && system.pole[begin].imag() == 0.0;
}

Complex modal_receptance(const PoleSystem& system, int mode, double f_hz) {
  const Complex s(0.0, two_pi * f_hz);
  Complex sum = 0.0;
  const long first = std::find(system.mode.begin(), system.mode.end(), mode) - system.mode.begin();
  long end = first;
  while (end < system.mode.size() && system.mode[end] == mode) ++end;
  if (end > first && is_rigid_pole(system, static_cast<int>(first), static_cast<int>(end))) {
    return 1.0 / (s * (s - system.pole[first]));
  }
  for (long k = first; k < end; ++k) {
    sum += 0.5 * (system.residue[k] / (s - system.pole[k]) +
                  std::conj(system.residue[k]) / (s - std::conj(system.pole[k])));
  }
  return sum;
}

}  // namespace struna::fem
