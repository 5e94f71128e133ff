#pragma once

#include <cmath>
#include <vector>

#include "ident/mode_identification.hpp"
#include "ident/references.hpp"
#include "simulated_doublet.hpp"
#include "synthetic_wire.hpp"

/// A nearly straight wire, bowed obliquely between its supports: each mode of bending is a doublet whose
/// spacing the bow rules. Shaken along y, then z, then x; three support forces each.
namespace struna::ident::simulated {

struct BowedWire {
  synthetic::Wire wire;
  std::vector<Pole> truth = {};  ///< of the doublet
  double lo_hz = 0.0;            ///< band around it
  double hi_hz = 0.0;
  double spacing = 0.0;  ///< of the two, in bandwidths
};

/// The doublet of the third mode of bending of a wire with this bow [m]; loss factor 0.02.
inline BowedWire bowed_wire(double bow, int elements = 24) {
  constexpr double angle = 0.6, length = 0.68, eta = 0.02;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= 8; ++i) {
    const double t = i / 8.0, w = 4.0 * bow * t * (1.0 - t) * (1.0 + 0.4 * (t - 0.5));
    points.emplace_back(length * t, w * std::cos(angle), w * std::sin(angle));
  }
  BowedWire bowed{synthetic::wire(fem::spline_through(points, length), 3, elements)};
  bowed.wire.model.body.material.loss_factor = fem::constant_law(eta);
  for (const long r : {4L, 5L}) {
    const double f = fem::natural_frequency_hz(bowed.wire.modes.eigenvalue[r],
                                               bowed.wire.model.body.material.youngs_modulus);
    bowed.truth.push_back({f, eta});
  }
  const double f = bowed.truth[0].natural_frequency_hz;
  bowed.spacing = (bowed.truth[1].natural_frequency_hz - f) / (eta * f);
  bowed.lo_hz = 0.75 * f;
  bowed.hi_hz = 1.3 * f;
  return bowed;
}

/// The bow that puts the two so many bandwidths apart.
inline BowedWire bowed_for(double spacing) {
  double lo = 1e-5, hi = 0.02;
  for (int i = 0; i < 30; ++i) {
    const double middle = std::sqrt(lo * hi);
    (bowed_wire(middle).spacing < spacing ? lo : hi) = middle;
  }
  return bowed_wire(hi);
}

/// Force over motion under so many references (y, z, x), noise-free, named as combine_references does.
inline TransferFunction references_of_wire(const BowedWire& bowed, int references, double step_hz) {
  const Eigen::Vector3d axes[] = {Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(),
                                  Eigen::Vector3d::UnitX()};
  fem::Measurement measurement = bowed.wire.measurement;
  measurement.directions.clear();
  TransferFunction tf;
  tf.frequency_hz = lines(bowed.lo_hz, bowed.hi_hz, step_hz);
  for (int j = 0; j < references; ++j)
    for (int o = 0; o < 3; ++o) {
      measurement.directions.push_back(bowed.wire.measurement.directions[static_cast<std::size_t>(o)]);
      measurement.drive_directions.push_back(axes[j]);
      std::string name = std::string("force_") + "yxz"[o];
      if (j > 0) name += std::string("@") + "yzx"[j];
      tf.outputs.push_back({name, FrfKind::dynamic_stiffness, "N/m", {}, {}, {}});
    }
  const Eigen::MatrixXcd response =
      fem::harmonic_response(bowed.wire.model, bowed.wire.drive, measurement, tf.frequency_hz).response;
  for (std::size_t k = 0; k < tf.outputs.size(); ++k)
    tf.outputs[k].value = response.col(static_cast<long>(k));
  return tf;
}

/// Noise of this share of the largest value of each output.
inline std::vector<double> noise_of(const TransferFunction& tf, double share) {
  std::vector<double> sigma;
  for (const auto& output : tf.outputs) sigma.push_back(share * output.value.cwiseAbs().maxCoeff());
  return sigma;
}

/// What becomes of the doublet with so many references, and how far the resolved ones are off in standard
/// errors (mean square of f and eta, expected 1).
struct ReferenceVerdicts : Verdicts {
  double square_sum = 0.0;
  long squares = 0;
  double frequency_sigma = 0.0;  ///< mean stated, in bandwidths, of the resolved
};
inline ReferenceVerdicts reference_verdicts(const BowedWire& bowed, int references, double noise,
                                            unsigned seeds) {
  const TransferFunction clean = references_of_wire(bowed, references, 0.1);
  const std::vector<double> sigma = noise_of(clean, noise);
  ReferenceVerdicts verdicts;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    TransferFunction tf = clean;
    add_noise(tf, sigma, seed);
    const ModeSet set = identify_modes(tf);
    const bool resolved = set.modes.size() == 2 && within_bars(set.modes[0], bowed.truth[0]) &&
                          within_bars(set.modes[1], bowed.truth[1]);
    const bool flagged =
        !set.modes.empty() &&
        std::none_of(set.modes.begin(), set.modes.end(), [](const Mode& mode) { return mode.flags.empty(); });
    ++(resolved ? verdicts.resolved : flagged ? verdicts.flagged : verdicts.wrong);
    if (!resolved) continue;
    for (std::size_t r = 0; r < 2; ++r) {
      const Mode& mode = set.modes[r];
      verdicts.square_sum +=
          std::pow((mode.natural_frequency_hz - bowed.truth[r].natural_frequency_hz) /
                       mode.natural_frequency_sigma,
                   2.0) +
          std::pow((mode.loss_factor - bowed.truth[r].loss_factor) / mode.loss_factor_sigma, 2.0);
      verdicts.squares += 2;
      verdicts.frequency_sigma += mode.natural_frequency_sigma / bandwidth_hz(bowed.truth[r]);
    }
  }
  return verdicts;
}

}  // namespace struna::ident::simulated
