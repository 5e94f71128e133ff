#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "fem/eigenmodes.hpp"
#include "fem/harmonic.hpp"
#include "fem/model.hpp"
#include "ident/mode.hpp"
#include "ident/pairing.hpp"

/// Wires and the mode lists that a measurement of them could give, flaws included.
namespace struna::ident::synthetic {

struct Wire {
  fem::Model model;
  fem::Drive drive;
  fem::Measurement measurement;
  ModelModes modes;
};

inline fem::Body wire_body(fem::Centreline centreline) {
  fem::Body body{"wire", std::move(centreline), {}, 7650.0, 0.3, {}};
  body.section = {8.042477e-6, 3.1083e-12, 2 * 3.1083e-12};
  body.material.youngs_modulus = fem::constant_law(1e11);
  return body;
}

/// Shaken at its start along y, turned by `angle` [rad] towards z; support forces read at its end in the
/// first `outputs` of y, x, z.
inline Wire wire(fem::Centreline centreline, int outputs, int elements = 30, double angle = 0.0) {
  Wire w{fem::assemble(wire_body(std::move(centreline)), elements), {}, {}, {}};
  w.drive = fem::SupportMotion{{fem::End::start}, Eigen::Vector3d(0.0, std::cos(angle), std::sin(angle))};
  const std::vector<Eigen::Vector3d> directions = {Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(),
                                                   Eigen::Vector3d::UnitZ()};
  w.measurement.what = fem::SupportForce{fem::End::end};
  w.measurement.directions.assign(directions.begin(), directions.begin() + outputs);
  const fem::Eigenmodes eigenmodes = fem::solve_eigenmodes(w.model, 60);
  w.modes.eigenvalue = eigenmodes.eigenvalue;
  w.modes.constant =
      fem::modal_constants(w.model, eigenmodes, w.drive, w.measurement, fem::constant_law(1.0));
  return w;
}

inline Wire curved_wire(int outputs = 3, int elements = 30, double angle = 0.0) {
  return wire(
      fem::spline_through(
          {{0, 0, 0}, {0.18, 0.06, 0.01}, {0.36, 0.02, 0.09}, {0.52, -0.05, 0.13}, {0.62, -0.02, 0.16}},
          0.68),
      outputs, elements, angle);
}
inline Wire straight_wire() {
  return wire(fem::straight_line({0, 0, 0}, {0.68, 0, 0}), 1);
}

inline fem::FrequencyLaw true_modulus() {
  return {fem::FrequencyLaw::Kind::power, {1e11, 0.02, 100.0}, {}, {}, 0.0, 0.0};
}

struct Flaws {
  double loss_factor = 0.0374;
  double frequency_noise = 0.01;  ///< of the half-power bandwidth
  double constant_noise = 0.05;   ///< of the constants' length
  double model_error = 0.003;     ///< of the model's natural frequencies
  double missing = 0.1;           ///< probability, of a mode as visible as its neighbours
  double doubled = 0.05;
  double spurious = 1.0;  ///< expected number
  double highest_hz = 1000.0;
};

struct Measured {
  ModeSet set;
  std::vector<std::vector<int>>
      truth;  ///< model modes behind each measured one; empty for a spurious or second one
};

inline Mode pole(double f, double loss_factor, const Eigen::VectorXcd& constant, const Flaws& flaws) {
  Mode mode;
  mode.natural_frequency_hz = f;
  mode.natural_frequency_sigma = std::max(1e-4, flaws.frequency_noise) * loss_factor * f;
  mode.loss_factor = loss_factor;
  mode.loss_factor_sigma = 0.02 * loss_factor;
  mode.damping_ratio = 0.5 * loss_factor;
  mode.modal_constant = constant;
  mode.modal_constant_sigma =
      Eigen::VectorXd::Constant(constant.size(), flaws.constant_noise * constant.norm() /
                                                     std::sqrt(2.0 * static_cast<double>(constant.size())));
  return mode;
}

/// The modes of `wire` below highest_hz at E(f) of true_modulus() as a flawed measurement gives them. Modes
/// nearer than 0.05 bandwidths are one pole, nearer than 0.3 every other time.
inline Measured measure(const Wire& wire, const Flaws& flaws, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const fem::FrequencyLaw modulus = true_modulus();
  const auto noisy = [&](const Eigen::VectorXd& constant) -> Eigen::VectorXcd {
    Eigen::VectorXcd c = constant.cast<std::complex<double>>();
    const double scale =
        flaws.constant_noise * constant.norm() / std::sqrt(2.0 * static_cast<double>(c.size()));
    for (auto& value : c) value += scale * std::complex<double>(normal(random), normal(random));
    return c;
  };
  struct Entry {
    Mode mode;
    std::vector<int> truth;
  };
  std::vector<Entry> entries;
  std::vector<double> frequency;
  for (Eigen::Index r = 0; r < wire.modes.eigenvalue.size(); ++r) {
    const double f = fem::natural_frequency_hz(wire.modes.eigenvalue[r], modulus);
    if (f > flaws.highest_hz) break;
    frequency.push_back(f);
  }
  double strongest = 0.0;
  for (std::size_t r = 0; r < frequency.size(); ++r) {
    strongest = std::max(strongest, wire.modes.constant.row(static_cast<Eigen::Index>(r)).norm() /
                                        wire.modes.eigenvalue[static_cast<Eigen::Index>(r)]);
  }
  for (std::size_t r = 0; r < frequency.size(); ++r) {
    std::vector<int> members{static_cast<int>(r)};
    while (r + 1 < frequency.size()) {
      const double spacing = (frequency[r + 1] / frequency[r] - 1.0) / flaws.loss_factor;
      if (spacing > 0.3 || (spacing > 0.05 && uniform(random) < 0.5)) break;
      members.push_back(static_cast<int>(++r));
    }
    Eigen::VectorXd constant = Eigen::VectorXd::Zero(wire.modes.constant.cols());
    for (int m : members) constant += wire.modes.constant.row(m).transpose();
    double f = 0.0, weights = 0.0;
    for (int m : members) {
      const double w = std::max(0.0, constant.dot(wire.modes.constant.row(m))) + 1e-300;
      f += w * frequency[static_cast<std::size_t>(m)];
      weights += w;
    }
    f /= weights;
    constant *= modulus.at(f);
    const double strength =
        constant.norm() / modulus.at(f) / wire.modes.eigenvalue[members.front()] / strongest;
    const double error =
        flaws.model_error * normal(random) + flaws.frequency_noise * flaws.loss_factor * normal(random);
    if (uniform(random) < flaws.missing || strength < 0.02 * uniform(random)) continue;
    const double measured_f = f * (1.0 + error);
    const double eta = flaws.loss_factor * (1.0 + 0.02 * normal(random));
    entries.push_back({pole(measured_f, eta, noisy(constant), flaws), members});
    if (uniform(random) < flaws.doubled) {  // one pole in two: a share of the constants, a little beside
      const double share = 0.05 + 0.3 * uniform(random);
      const double beside = measured_f * (1.0 + (uniform(random) < 0.5 ? -0.5 : 0.5) * eta);
      entries.push_back({pole(beside, eta, noisy(share * constant), flaws), {}});
    }
  }
  const int spurious = std::poisson_distribution<int>(flaws.spurious)(random);
  for (int k = 0; k < spurious && flaws.spurious > 0.0; ++k) {
    const double f = 15.0 * std::pow(flaws.highest_hz / 15.0, uniform(random));
    Eigen::VectorXd constant(wire.modes.constant.cols());
    for (double& c : constant) c = normal(random);
    constant *= 0.3 * strongest * std::pow(2.0 * std::numbers::pi * f, 2);
    entries.push_back({pole(f, flaws.loss_factor * (0.2 + uniform(random)), noisy(constant), flaws), {}});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.mode.natural_frequency_hz < b.mode.natural_frequency_hz;
  });
  Measured measured;
  measured.set.form = FrfKind::apparent_mass;
  for (Entry& entry : entries) {
    measured.set.modes.push_back(std::move(entry.mode));
    measured.truth.push_back(std::move(entry.truth));
  }
  return measured;
}

struct Score {
  int right = 0;
  int wrong = 0;     ///< a pair whose model modes are not behind the measured one
  int left_out = 0;  ///< true modes not paired
  int spurious_paired = 0;
};

inline Score score(const Pairing& pairing, const Measured& measured) {
  Score s;
  std::vector<bool> paired(measured.truth.size(), false);
  for (const Pair& pair : pairing.pairs) {
    const auto i = static_cast<std::size_t>(pair.measured);
    paired[i] = true;
    bool common = false;
    for (int m : pair.model) {
      common |= std::find(measured.truth[i].begin(), measured.truth[i].end(), m) != measured.truth[i].end();
    }
    if (measured.truth[i].empty()) {
      ++s.spurious_paired;
    } else {
      ++(common ? s.right : s.wrong);
    }
  }
  for (std::size_t i = 0; i < paired.size(); ++i) s.left_out += !paired[i] && !measured.truth[i].empty();
  return s;
}

}  // namespace struna::ident::synthetic
