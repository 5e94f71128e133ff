#include "apps/limit_pairing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "fem/error.hpp"
#include "ident/doubts.hpp"
#include "ident/elastic_modes.hpp"

namespace struna::apps {
namespace {

constexpr double highest_hz = 700.0;
constexpr double loss_factor = 0.0374;
constexpr double one_pole = 0.3;           // bandwidths between modes that are seen as one
constexpr double model_error = 0.001;      // of a natural frequency
constexpr double frequency_noise = 0.01;   // of the bandwidth
constexpr double constant_noise = 0.05;    // of the constants' length
constexpr double spurious_strength = 0.3;  // of the strongest mode's answer at its own frequency
const fem::FrequencyLaw true_modulus{fem::FrequencyLaw::Kind::power, {1e11, 0.02, 100.0}, {}, {}, 0.0, 0.0};

/// A wire whose start is shaken along y and whose far support forces are read.
struct Wire {
  fem::Model model;
  fem::Drive drive;
  fem::Measurement measurement;
  ident::ModelModes modes;
};

Wire curved_wire() {
  fem::Body body{
      "wire",
      fem::spline_through(
          {{0, 0, 0}, {0.18, 0.06, 0.01}, {0.36, 0.02, 0.09}, {0.52, -0.05, 0.13}, {0.62, -0.02, 0.16}},
          0.68),
      {8.042477e-6, 3.1083e-12, 2 * 3.1083e-12},
      7650.0,
      0.3,
      {}};
  body.material.youngs_modulus = true_modulus;
  Wire wire{fem::assemble(body, 30), {}, {}, {}};
  wire.drive = fem::SupportMotion{{fem::End::start}, Eigen::Vector3d::UnitY()};
  wire.measurement.what = fem::SupportForce{fem::End::end};
  wire.measurement.directions = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                 Eigen::Vector3d::UnitZ()};
  wire.modes = ident::elastic_modes(wire.model, wire.drive, wire.measurement, 60).modes;
  return wire;
}

/// A list of modes, and the model modes that stand behind each; none: it is spurious.
struct Measured {
  ident::ModeSet set;
  std::vector<std::vector<int>> truth;
};

ident::Mode measured_mode(double f_hz, const Eigen::VectorXcd& constant) {
  ident::Mode mode;
  mode.natural_frequency_hz = mode.circle_natural_frequency_hz = f_hz;
  mode.natural_frequency_sigma = frequency_noise * loss_factor * f_hz;
  mode.loss_factor = loss_factor;
  mode.loss_factor_sigma = 0.02 * loss_factor;
  mode.damping_ratio = 0.5 * loss_factor;
  mode.lower_half_power_hz = f_hz * (1.0 - 0.5 * loss_factor);
  mode.upper_half_power_hz = f_hz * (1.0 + 0.5 * loss_factor);
  mode.modal_constant = constant;
  mode.modal_constant_sigma =
      Eigen::VectorXd::Constant(constant.size(), constant_noise * constant.norm() /
                                                     std::sqrt(2.0 * static_cast<double>(constant.size())));
  return mode;
}

/// Model modes below highest_hz, those that one pole stands for together.
std::vector<std::vector<int>> poles_of(const Wire& wire) {
  std::vector<std::vector<int>> poles;
  double last = 0.0;
  for (int r = 0; r < wire.modes.eigenvalue.size(); ++r) {
    const double f = fem::natural_frequency_hz(wire.modes.eigenvalue[r], true_modulus);
    if (f > highest_hz) break;
    if (f - last < one_pole * loss_factor * f)
      poles.back().push_back(r);
    else
      poles.push_back({r});
    last = f;
  }
  return poles;
}

class Measuring {
 public:
  Measuring(const Wire& wire, unsigned seed) : wire_(wire), engine_(seed) {}

  Measured modes(double missing, int spurious) {
    const auto poles = poles_of(wire_);
    double strongest = 0.0;
    for (const auto& pole : poles)
      strongest = std::max(
          strongest, wire_.modes.constant.row(pole.front()).norm() / wire_.modes.eigenvalue[pole.front()]);
    for (const auto& pole : poles) add(pole, missing, strongest);
    for (int k = 0; k < spurious; ++k) {
      const double f = 15.0 * std::pow(highest_hz / 15.0, uniform_(engine_));
      Eigen::VectorXd constant(wire_.modes.constant.cols());
      for (double& c : constant) c = normal_(engine_);
      entries_.push_back({measured_mode(f, noisy(spurious_strength * strongest *
                                                 std::pow(2.0 * std::numbers::pi * f, 2.0) * constant)),
                          {}});
    }
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
      return a.mode.natural_frequency_hz < b.mode.natural_frequency_hz;
    });
    Measured measured;
    measured.set.form = ident::FrfKind::apparent_mass;
    measured.set.outputs = {"force_x", "force_y", "force_z"};
    for (const Entry& entry : entries_) {
      measured.set.modes.push_back(entry.mode);
      measured.truth.push_back(entry.truth);
    }
    return measured;
  }

 private:
  struct Entry {
    ident::Mode mode;
    std::vector<int> truth;
  };

  void add(const std::vector<int>& pole, double missing, double strongest) {
    Eigen::VectorXd constant = Eigen::VectorXd::Zero(wire_.modes.constant.cols());
    for (const int m : pole) constant += wire_.modes.constant.row(m).transpose();
    double f = 0.0, weights = 0.0;  // where the common pole of nearly equal modes lies
    for (const int m : pole) {
      const double weight = std::max(0.0, constant.dot(wire_.modes.constant.row(m))) + 1e-300;
      f += weight * fem::natural_frequency_hz(wire_.modes.eigenvalue[m], true_modulus);
      weights += weight;
    }
    f /= weights;
    const double strength = constant.norm() / wire_.modes.eigenvalue[pole.front()] / strongest;
    const double error = model_error * normal_(engine_) + frequency_noise * loss_factor * normal_(engine_);
    const bool lost = uniform_(engine_) < missing || strength < 0.02 * uniform_(engine_);
    const Eigen::VectorXcd seen = noisy(true_modulus.at(f) * constant);
    if (!lost) entries_.push_back({measured_mode(f * (1.0 + error), seen), pole});
  }

  Eigen::VectorXcd noisy(const Eigen::VectorXd& constant) {
    Eigen::VectorXcd c = constant.cast<std::complex<double>>();
    const double scale =
        constant_noise * constant.norm() / std::sqrt(2.0 * static_cast<double>(constant.size()));
    for (auto& value : c) {
      const double re = normal_(engine_), im = normal_(engine_);
      value += scale * std::complex<double>(re, im);
    }
    return c;
  }

  const Wire& wire_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  std::vector<Entry> entries_;
};

bool is_true(const ident::Pair& pair, const Measured& measured) {
  const auto& truth = measured.truth[static_cast<std::size_t>(pair.measured)];
  return std::find_first_of(pair.model.begin(), pair.model.end(), truth.begin(), truth.end()) !=
         pair.model.end();
}

/// Whether E(f) has the pair.
bool is_trusted(const ident::Pair& pair, const Measured& measured,
                const ident::IdentifiedParameters& identified) {
  const double f = measured.set.modes[static_cast<std::size_t>(pair.measured)].natural_frequency_hz;
  return (identified.modulus.frequency_hz.array() == f).any();
}

/// Whether a doubt says that pairs may be false. That modes are missing from the list or none of the wire's
/// is a statement about the list, true or not whatever the pairs are; and a law that two or three modes do
/// not allow to choose is one about the law.
bool questions_pairs(const ident::Doubt& doubt) {
  switch (doubt.kind) {
    case ident::DoubtKind::modes_unpaired:
    case ident::DoubtKind::modes_unseen:
      return false;
    case ident::DoubtKind::law_misfit:
      return doubt.names.front() == "modulus" && doubt.names.size() == 2;
    default:
      return true;
  }
}

}  // namespace

LimitMap pairing_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "pairing";
  map.title = "Pairing: modes missing and modes that are none";
  map.quantity = "whether a pair is false (1) or true (0)";
  map.fails = "a spurious mode takes the place of a missing one, or a short list fits another modulus";
  map.sign = "constants that stand out from the others', and other pairs or chance nearly as probable";
  map.then = "leaves the mode out, or doubts the whole (pairing_open)";
  map.axes = {run.axis("modes missing [%]", {0, 10, 30, 50, 70, 85}),
              run.axis("spurious modes [-]", {0, 1, 2, 4}),
              run.axis("modulus of the scene over the true one [-]", {0.3, 1, 3})};
  const Wire wire = curved_wire();
  for_each_place(map.axes, [&](const std::vector<double>& at) {
    fem::Model model = wire.model;
    model.body.material.youngs_modulus = fem::constant_law(at[2] * true_modulus.parameters[0]);
    for (const unsigned seed : run.draws(4)) {
      const Measured measured = Measuring(wire, seed).modes(0.01 * at[0], static_cast<int>(at[1]));
      LimitTrial trial;
      trial.at = at;
      trial.seed = seed;
      try {
        const ident::FitOptions options;
        const auto identified =
            ident::identify_parameters(measured.set, model, wire.drive, wire.measurement, options);
        for (const ident::Doubt& doubt : ident::identification_doubts(measured.set, model, wire.drive,
                                                                      wire.measurement, options, identified))
          if (questions_pairs(doubt))
            trial.flags += (trial.flags.empty() ? "" : ";") + ident::to_string(doubt.kind);
        for (const ident::Pair& pair : identified.pairing.pairs) {
          map.trials.push_back(trial);
          map.trials.back().error = is_true(pair, measured) ? 0.0 : 1.0;
          if (!is_trusted(pair, measured, identified))
            map.trials.back().flags += (trial.flags.empty() ? "" : ";") + std::string("rejected");
        }
      } catch (const Error&) {
        trial.refused = true;
        map.trials.push_back(std::move(trial));
      }
    }
  });
  return map;
}

}  // namespace struna::apps
