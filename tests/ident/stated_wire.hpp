#pragma once

#include <cmath>
#include <random>

#include "ident/elastic_modes.hpp"
#include "ident/parameter_identification.hpp"
#include "tests/ident/synthetic_wire.hpp"

/// Wires whose scene states numbers with errors, and the modes that a measurement of the true one gives.
namespace struna::ident::stated {

struct Wire {
  fem::Body body;
  fem::Drive drive;
  fem::Measurement measurement;
};

constexpr int elements = 24;
constexpr double diameter = 0.0032;

/// Solid circle, diameter, length and density stated with sigmas (absolute).
inline Wire wire(bool curved, double diameter_sigma = 0.0, double length_sigma = 0.0,
                 double density_sigma = 0.0) {
  const synthetic::Wire w = curved ? synthetic::curved_wire(3, 4, 0.4) : synthetic::straight_wire();
  Wire result{w.model.body, w.drive, w.measurement};
  fem::Body& body = result.body;
  body.section = fem::solid_circle(diameter);
  fem::BodyNumber d{.name = "diameter", .value = diameter, .sigma = diameter_sigma};
  d.section = {2.0 * body.section.area / diameter, 4.0 * body.section.second_moment / diameter,
               4.0 * body.section.torsion_constant / diameter};
  const double length = body.centreline.length();
  body.stated = {d,
                 {.name = "length", .value = length, .sigma = length_sigma, .length = 1.0},
                 {.name = "density", .value = body.density, .sigma = density_sigma, .density = 1.0}};
  return result;
}

/// The modes up to highest_hz of `truth` with the modulus law, each a sound one, frequencies off by a normal
/// error of `noise` (relative). Modes that coincide, as those of a straight wire's planes do, are one.
inline ModeSet measured(const Wire& truth, const fem::FrequencyLaw& modulus, double highest_hz, double noise,
                        unsigned seed) {
  fem::Body body = truth.body;
  body.material.youngs_modulus = modulus;
  const fem::Model model = fem::assemble(body, elements);
  const ElasticModes found = elastic_modes(model, truth.drive, truth.measurement, 60);
  const ModelModes& modes = found.modes;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  ModeSet set;
  set.form = FrfKind::apparent_mass;
  double strongest = 0.0;
  for (Eigen::Index r = 0; r < modes.eigenvalue.size(); ++r) {
    const double f = fem::natural_frequency_hz(modes.eigenvalue[r], modulus);
    if (f > highest_hz) break;
    Eigen::VectorXd constant = modes.constant.row(r);
    while (r + 1 < modes.eigenvalue.size() && modes.eigenvalue[r + 1] < (1.0 + 1e-6) * modes.eigenvalue[r])
      constant += modes.constant.row(++r);
    constant *= modulus.at(f);
    strongest = std::max(strongest, constant.norm());
    if (constant.norm() < 1e-6 * strongest) continue;  // across the drive
    Mode mode;
    mode.natural_frequency_hz = f * (1.0 + noise * normal(random));
    mode.natural_frequency_sigma = std::max(noise, 1e-6) * f;
    mode.loss_factor = 0.01;
    mode.loss_factor_sigma = 1e-4;
    mode.damping_ratio = 0.005;
    mode.modal_constant = constant.cast<std::complex<double>>();
    mode.modal_constant_sigma = Eigen::VectorXd::Constant(constant.size(), 0.01 * constant.norm());
    set.modes.push_back(mode);
  }
  return set;
}

/// Without floors: the sigmas of the modes are the truth.
inline FitOptions bare() {
  FitOptions options;
  options.modulus_floor = 0.0;
  options.loss_factor_floor = 0.0;
  options.modulus_law = "power";
  return options;
}

inline IdentifiedParameters fitted(const ModeSet& modes, const Wire& scene, const FitOptions& options) {
  return identify_parameters(modes, fem::assemble(scene.body, elements), scene.drive, scene.measurement,
                             options);
}

}  // namespace struna::ident::stated
