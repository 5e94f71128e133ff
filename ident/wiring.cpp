#include "ident/wiring.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"
#include "ident/pairing_cost.hpp"

namespace struna::ident {
namespace {

constexpr double same_shape = 0.8;  // correlation over the outputs; of random vectors of three a fifth has it
constexpr double same_strength = std::numbers::ln2;  // of ln |C| about the common factor
constexpr double remedy_share = 0.8;                 // of the modes that must agree …
constexpr double remedy_gain = 0.2;                  // … and how many more than without
constexpr double other_direction = 0.9;              // cosine above which a drive is along the axis already

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool is_sound(const Mode& mode, const Candidate& candidate) {
  const bool doubtful = mode.has(ModeFlag::noisy) || mode.has(ModeFlag::poor_circle) ||
                        mode.has(ModeFlag::edge) || mode.has(ModeFlag::not_converged);
  return !doubtful && candidate.constant.size() > 0;
}

/// What a pair says: correlation with the model's constants, and the logarithm of the ratio of their lengths.
struct Likeness {
  double correlation = 0.0;
  double least_correlation = 0.0;
  double ln_ratio = 0.0;
  double mac = 0.0;
};

Likeness likeness(const Candidate& measured, const Pair& pair, const ModelModes& model, double sign) {
  Eigen::VectorXd constant = Eigen::VectorXd::Zero(model.constant.cols());
  for (int r : pair.model) constant += model.constant.row(r).transpose();
  const double lengths = measured.constant.norm() * constant.norm();
  if (!(lengths > 0.0)) return {0.0, 1.0, std::numeric_limits<double>::infinity(), 0.0};
  const double scale = model.constant_scales_with_modulus ? pair.modulus : 1.0;
  return {sign * measured.constant.real().dot(constant) / lengths,
          same_shape / std::sqrt(1.0 + measured.noise),
          std::log(measured.constant.norm() / (scale * constant.norm())), pair.mac};
}

ModelModes reversed(ModelModes model, Eigen::Index output) {
  model.constant.col(output) *= -1.0;
  return model;
}

ModelModes permuted(const ModelModes& model, const std::vector<int>& measured_as) {
  ModelModes result = model;
  for (std::size_t k = 0; k < measured_as.size(); ++k) {
    result.constant.col(measured_as[k]) = model.constant.col(static_cast<Eigen::Index>(k));
  }
  return result;
}

/// Orders other than the one at hand: all of up to three outputs, else those with two exchanged.
std::vector<std::vector<int>> exchanges(int outputs) {
  std::vector<int> order(static_cast<std::size_t>(outputs));
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::vector<int>> list;
  if (outputs <= 3) {
    while (std::next_permutation(order.begin(), order.end())) list.push_back(order);
  } else {
    for (std::size_t i = 0; i < order.size(); ++i) {
      for (std::size_t j = i + 1; j < order.size(); ++j) {
        list.push_back(order);
        std::swap(list.back()[i], list.back()[j]);
      }
    }
  }
  const auto moved = [](const std::vector<int>& list_order) {
    int count = 0;
    for (std::size_t k = 0; k < list_order.size(); ++k) count += list_order[k] != static_cast<int>(k);
    return count;
  };
  std::stable_sort(list.begin(), list.end(),
                   [&](const auto& a, const auto& b) { return moved(a) < moved(b); });
  return list;
}

/// The drive along another direction; none where that support is not held in it, so that nothing shakes it.
std::optional<ModelModes> driven_along(const fem::Model& model, fem::Drive drive,
                                       const fem::Measurement& measurement, const Eigen::Vector3d& direction,
                                       int count) {
  std::visit([&](auto& driven) { driven.direction = direction; }, drive);
  try {
    return elastic_modes(model, drive, measurement, count).modes;
  } catch (const Error&) {
    return std::nullopt;
  }
}

Eigen::Vector3d direction_of(const fem::Drive& drive) {
  return std::visit([](const auto& driven) { return driven.direction; }, drive);
}

}  // namespace

ShapeAgreement shape_agreement(const ModeSet& measured, const ModelModes& model, const Pairing& pairing) {
  ShapeAgreement result;
  if (measured.modes.empty()) return result;
  const std::vector<Candidate> candidates = PairingCost(measured, model, {}).candidates();
  const auto sound = [&](int i) {
    return is_sound(measured.modes[static_cast<std::size_t>(i)], candidates[static_cast<std::size_t>(i)]);
  };
  for (int i = 0; i < static_cast<int>(candidates.size()); ++i) result.modes += sound(i);
  std::vector<Likeness> list;
  std::vector<double> macs, ratios;
  for (const Pair& pair : pairing.pairs) {
    if (!sound(pair.measured)) continue;
    const Candidate& candidate = candidates[static_cast<std::size_t>(pair.measured)];
    list.push_back(likeness(candidate, pair, model, pairing.sign_reversed ? -1.0 : 1.0));
    macs.push_back(list.back().mac);
    ratios.push_back(list.back().ln_ratio);
  }
  result.pairs = static_cast<int>(list.size());
  if (list.empty()) return result;
  result.median_mac = median(macs);
  const double level = median(ratios);
  std::vector<double> deviation;
  for (const Likeness& one : list) {
    deviation.push_back(std::abs(one.ln_ratio - level));
    result.agreeing += one.correlation >= one.least_correlation && deviation.back() <= same_strength;
  }
  if (measured.form != FrfKind::unknown) result.level = std::exp(level);
  result.level_scatter_db = 1.48 * median(deviation) * 20.0 / std::numbers::ln10;
  return result;
}

std::optional<Remedy> find_remedy(const ModeSet& measured, const fem::Model& model, const fem::Drive& drive,
                                  const fem::Measurement& measurement, const PairingOptions& options,
                                  const ShapeAgreement& now) {
  const int count = modes_to_solve(measured.modes.size());
  const ModelModes as_wired = elastic_modes(model, drive, measurement, count).modes;
  std::optional<Remedy> best;
  const auto try_out = [&](Remedy remedy, const ModelModes& changed) {
    remedy.agreement = shape_agreement(measured, changed, pair_modes(measured, changed, options));
    const bool better = !best || remedy.agreement.agreeing > best->agreement.agreeing;
    if (better) best = remedy;
  };
  const int outputs = static_cast<int>(as_wired.constant.cols());
  for (int k = 0; k < outputs && outputs > 1; ++k) {
    try_out({Remedy::Change::output_reversed, {k}, {}, {}}, reversed(as_wired, k));
  }
  for (const std::vector<int>& order : exchanges(outputs)) {
    try_out({Remedy::Change::outputs_exchanged, order, {}, {}}, permuted(as_wired, order));
  }
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(Eigen::Vector3d::UnitX()), Eigen::Vector3d(Eigen::Vector3d::UnitY()),
        Eigen::Vector3d(Eigen::Vector3d::UnitZ())}) {
    if (!measurement.drive_directions.empty()) break;  // each reference tells its own
    if (std::abs(axis.dot(direction_of(drive))) > other_direction) continue;
    const auto changed = driven_along(model, drive, measurement, axis, count);
    if (changed) try_out({Remedy::Change::driven_along, {}, axis, {}}, *changed);
  }
  if (!best) return std::nullopt;
  const int agreeing = best->agreement.agreeing;
  const bool enough = agreeing >= remedy_share * now.modes &&
                      agreeing >= now.agreeing + std::max(2.0, remedy_gain * now.modes);
  return enough ? best : std::nullopt;
}

}  // namespace struna::ident
