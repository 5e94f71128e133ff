#include "ident/parameter_identification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"
#include "ident/elastic_modes.hpp"
#include "ident/joint_fit.hpp"
#include "ident/mode_trust.hpp"
#include "ident/references.hpp"

namespace struna::ident {
namespace {

using Kind = fem::FrequencyLaw::Kind;

constexpr int most_rounds = 8;  // of pairing and fitting numbers of the body

void validate(const FitOptions& options) {
  const bool band_given = options.band_lo_hz != 0.0 || options.band_hi_hz != 0.0;
  if (band_given && !(options.band_lo_hz >= 0.0 && options.band_hi_hz > options.band_lo_hz)) {
    throw Error(fmt::format("identify_parameters: 0 <= band_lo_hz < band_hi_hz, got {} and {}",
                            options.band_lo_hz, options.band_hi_hz));
  }
  const auto check_floor = [](const char* name, double value) {
    if (!(value >= 0.0 && value < 1.0)) {
      throw Error(fmt::format("identify_parameters: 0 <= {} < 1, got {}", name, value));
    }
  };
  check_floor("modulus_floor", options.modulus_floor);
  for (const std::string& word : {options.modulus_law, options.loss_factor_law}) {
    if (!word.empty()) fitted_law(word);
  }
  check_floor("loss_factor_floor", options.loss_factor_floor);
  for (const std::string& name : options.free) {
    const std::vector<std::string> known = fem::fittable_numbers();
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error(fmt::format("identify_parameters: free: only {} can be fitted, got \"{}\"",
                              fmt::join(known, ", "), name));
  }
}

/// The measured modes in the band; `index` keeps their places in the list.
struct Selection {
  ModeSet set;
  std::vector<int> index;
};

Selection in_band(const ModeSet& measured, const FitOptions& options, std::vector<LeftOut>& rejected) {
  Selection selection;
  selection.set = measured;
  selection.set.modes.clear();
  for (std::size_t i = 0; i < measured.modes.size(); ++i) {
    const double f = measured.modes[i].natural_frequency_hz;
    if (options.band_hi_hz > 0.0 && (f < options.band_lo_hz || f > options.band_hi_hz)) {
      rejected.push_back(
          {f, fmt::format("outside the band of the fit, {} to {} Hz", options.band_lo_hz, options.band_hi_hz),
           LeftOutOf::both});
      continue;
    }
    selection.set.modes.push_back(measured.modes[i]);
    selection.index.push_back(static_cast<int>(i));
  }
  return selection;
}

struct Points {
  std::vector<double> frequency, value, sigma;

  void add(double f, double v, double s) {
    frequency.push_back(f);
    value.push_back(v);
    sigma.push_back(s);
  }
  IdentifiedCurve curve() const {
    const auto vector = [](const std::vector<double>& v) {
      return Eigen::VectorXd(
          Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size())));
    };
    return {vector(frequency), vector(value), vector(sigma), {}};
  }
};

/// Sorts the pairs' moduli and loss factors (as read, not yet freed of the rising modulus) into the trusted
/// and the rejected.
void sort_by_trust(const Selection& selection, const Pairing& pairing, const ModelModes& model,
                   const FitOptions& options, Points& modulus, Points& loss_factor,
                   std::vector<LeftOut>& rejected) {
  for (const Unpaired& unpaired : pairing.left_out) {
    const double f = selection.set.modes[static_cast<std::size_t>(unpaired.measured)].natural_frequency_hz;
    rejected.push_back({f, unpaired.reason, LeftOutOf::both});
  }
  const bool several = references_of(selection.set.outputs).several();  // which part the closest
  for (const Pair& pair : pairing.pairs) {
    const auto i = static_cast<std::size_t>(pair.measured);
    const Mode& mode = selection.set.modes[i];
    const double f = mode.natural_frequency_hz;
    if (const auto reason = distrust_both(mode)) {
      rejected.push_back({f, *reason, LeftOutOf::both});
      continue;
    }
    const double sigma = relative_modulus_sigma(pair, mode, options.modulus_floor);
    if (const auto reason = distrust_modulus(sigma)) {
      rejected.push_back({f, *reason, LeftOutOf::modulus});
    } else {
      modulus.add(f, pair.modulus, sigma * pair.modulus);
    }
    const double spread = mode.loss_factor > 0.0 ? pair.spread / mode.loss_factor : 0.0;
    const Surroundings around{spread, neighbour_distance(selection.set.modes, i),
                              missing_distance(pairing, model, pair, mode.loss_factor), several};
    if (const auto reason = distrust_loss_factor(pair, mode, around)) {
      rejected.push_back({f, *reason, LeftOutOf::loss_factor});
    } else {
      loss_factor.add(f, mode.loss_factor,
                      relative_loss_factor_sigma(mode, options.loss_factor_floor) * mode.loss_factor);
    }
  }
  std::stable_sort(rejected.begin(), rejected.end(),
                   [](const LeftOut& a, const LeftOut& b) { return a.frequency_hz < b.frequency_hz; });
}

/// All laws that the points determine, the named one first.
std::vector<LawFit> fit_curve_laws(const IdentifiedCurve& curve, std::vector<Kind> kinds, bool rising,
                                   const std::string& named, const char* what) {
  std::optional<Kind> wanted;
  if (!named.empty()) {
    wanted = fitted_law(named);
    if (std::find(kinds.begin(), kinds.end(), *wanted) == kinds.end()) kinds.push_back(*wanted);
  }
  std::vector<LawFit> laws = fit_laws(curve.frequency_hz, curve.value, curve.sigma, kinds, rising);
  if (!wanted) return laws;
  const auto at =
      std::find_if(laws.begin(), laws.end(), [&](const LawFit& fit) { return fit.law.kind == *wanted; });
  if (at == laws.end()) {
    throw Error(
        fmt::format("{} law: the {} trusted modes do not determine a {} law; leave the choice open or name a "
                    "simpler one",
                    what, curve.value.size(), named));
  }
  std::rotate(laws.begin(), at, at + 1);
  return laws;
}

std::string nothing_paired(const ModeSet& measured, const Pairing& pairing) {
  std::string message =
      fmt::format("identify_parameters: none of the {} measured modes could be paired with the model",
                  measured.modes.size());
  if (!pairing.left_out.empty()) message += fmt::format(" (first: {})", pairing.left_out.front().reason);
  return message + "; check geometry, density, end conditions, drive and output directions";
}

/// From the places among the modes that were paired to those among all measured and all model modes.
void to_list_indices(Pairing& pairing, const std::vector<int>& index, int rigid) {
  for (Pair& pair : pairing.pairs) {
    pair.measured = index[static_cast<std::size_t>(pair.measured)];
    for (int& mode : pair.model) mode += rigid;
  }
  for (int& mode : pairing.missing) mode += rigid;
  for (Unpaired& unpaired : pairing.left_out) {
    unpaired.measured = index[static_cast<std::size_t>(unpaired.measured)];
  }
}

}  // namespace

std::string to_string(LeftOutOf what) {
  switch (what) {
    case LeftOutOf::both:
      return "both";
    case LeftOutOf::modulus:
      return "modulus";
    case LeftOutOf::loss_factor:
      return "loss_factor";
  }
  throw Error("to_string: no such LeftOutOf");
}

LeftOutOf left_out_of(const std::string& word) {
  for (LeftOutOf what : {LeftOutOf::both, LeftOutOf::modulus, LeftOutOf::loss_factor}) {
    if (word == to_string(what)) return what;
  }
  throw Error(fmt::format("of: both, modulus or loss_factor, got \"{}\"", word));
}

Kind fitted_law(const std::string& word) {
  for (const Kind kind : {Kind::constant, Kind::power, Kind::fractional_zener, Kind::monotone_spline}) {
    if (word == fem::to_string(kind)) return kind;
  }
  throw Error(fmt::format("law: constant, power, fractional_zener or monotone_spline, got \"{}\"", word));
}

namespace {

struct Identified {
  IdentifiedParameters parameters;
  fem::Eigenmodes eigenmodes;
  int rigid = 0;
  std::vector<PairedFrequency> pairs;  ///< behind the entries of parameters.modulus
};

std::vector<PairedFrequency> paired_frequencies(const ModeSet& set, const Pairing& pairing,
                                                const IdentifiedCurve& modulus) {
  std::vector<PairedFrequency> pairs;
  Eigen::Index next = 0;
  for (const Pair& pair : pairing.pairs) {
    const double f = set.modes[static_cast<std::size_t>(pair.measured)].natural_frequency_hz;
    if (next >= modulus.value.size() || modulus.frequency_hz[next] != f) continue;
    pairs.push_back({f, pair.model, modulus.sigma[next] / modulus.value[next]});
    ++next;
  }
  return pairs;
}

/// Everything but the numbers of the body, which `fitted` tells where some were fitted already.
Identified identify_material(const ModeSet& measured, const fem::Model& model, const fem::Drive& drive,
                             const fem::Measurement& measurement, const FitOptions& options,
                             const FittedNumbers& fitted) {
  IdentifiedParameters result;
  result.body = model.body.name;
  const Selection selection = in_band(measured, options, result.rejected);
  if (selection.set.modes.empty()) {
    throw Error("identify_parameters: at least one measured mode in the band, got none");
  }
  PairingOptions pairing_options = options.pairing;
  if (options.band_hi_hz > 0.0) {
    pairing_options.band_lo_hz = options.band_lo_hz;
    pairing_options.band_hi_hz = options.band_hi_hz;
  }
  const ElasticModes model_side =
      elastic_modes(model, drive, measurement, modes_to_solve(selection.set.modes.size()));
  result.pairing = pair_modes(selection.set, model_side.modes, pairing_options);

  Points modulus, loss_factor;
  sort_by_trust(selection, result.pairing, model_side.modes, options, modulus, loss_factor, result.rejected);
  if (modulus.value.empty()) throw Error(nothing_paired(selection.set, result.pairing));
  result.modulus = modulus.curve();
  const std::vector<PairedFrequency> pairs =
      paired_frequencies(selection.set, result.pairing, result.modulus);
  to_list_indices(result.pairing, selection.index, model_side.rigid);
  result.modulus.laws = fit_curve_laws(
      result.modulus, {Kind::constant, Kind::power, Kind::fractional_zener, Kind::monotone_spline}, true,
      options.modulus_law, "modulus");

  result.fitted = fitted;
  result.errors = body_error_steps(model, model_side.eigenmodes, pairs, result.modulus.laws.front(), fitted);
  const auto common_sigma = [&](bool of_fitted) {
    const Eigen::VectorXd relative = common_modulus_sigma(result.errors, of_fitted);
    return relative.size() > 0 ? Eigen::VectorXd(relative.cwiseProduct(result.modulus.value)) : relative;
  };
  result.modulus.scene_sigma = common_sigma(false);
  result.modulus.fitted_sigma = common_sigma(true);

  const fem::FrequencyLaw& modulus_law = result.modulus.laws.front().law;
  result.loss_factor = loss_factor.curve();
  IdentifiedCurve& eta = result.loss_factor;
  result.kramers_kronig_loss_factor.resize(eta.value.size());
  for (Eigen::Index i = 0; i < eta.value.size(); ++i) {
    const double slope = modulus_law.log_slope(eta.frequency_hz[i]);
    eta.value[i] *= 1.0 - 0.5 * slope;
    eta.sigma[i] *= 1.0 - 0.5 * slope;
    result.kramers_kronig_loss_factor[i] = 0.5 * std::numbers::pi * slope;
  }
  if (eta.value.size() > 0) {
    eta.laws = fit_curve_laws(eta, {Kind::constant, Kind::power, Kind::monotone_spline}, false,
                              options.loss_factor_law, "loss factor");
    result.rayleigh = fit_rayleigh(eta.frequency_hz, 0.5 * eta.value, 0.5 * eta.sigma);
    result.rayleigh_known = true;
  }
  const auto by_frequency = [](const Mode& a, const Mode& b) {
    return a.natural_frequency_hz < b.natural_frequency_hz;
  };
  const auto& listed = selection.set.modes;
  const auto [lowest, highest] = std::minmax_element(listed.begin(), listed.end(), by_frequency);
  result.provenance.band_lo_hz = options.band_hi_hz > 0.0 ? options.band_lo_hz : lowest->natural_frequency_hz;
  result.provenance.band_hi_hz =
      options.band_hi_hz > 0.0 ? options.band_hi_hz : highest->natural_frequency_hz;
  return {std::move(result), model_side.eigenmodes, model_side.rigid, pairs};
}

/// Springs that are fitted keep their stiffness over the modulus when that changes.
void keep_ratio(fem::Body& body, const std::vector<std::string>& free, const fem::FrequencyLaw& modulus) {
  const double ratio =
      modulus.at(fem::support_reference_hz) / body.material.youngs_modulus.at(fem::support_reference_hz);
  for (const std::string& name : free) {
    if (!is_relative(name) || name == "torsion_constant") continue;
    const fem::BodyNumber number = fem::fittable_number(body, name);
    body = fem::moved(body, number, (ratio - 1.0) * number.value);
  }
  body.material.youngs_modulus = modulus;
}

bool same_pairs(const std::vector<PairedFrequency>& a, const std::vector<PairedFrequency>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.frequency_hz == y.frequency_hz && x.mode == y.mode;
  });
}

/// Numbers fitted beside the law from one start.
struct Trial {
  Identified found;
  FittedNumbers fitted;
  fem::Body body;
  double chi_square = 0.0;

  /// More pairs explained, or the same number better.
  bool is_better_than(const Trial& other) const {
    const std::size_t mine = found.pairs.size(), its = other.found.pairs.size();
    return mine != its ? mine > its : chi_square < other.chi_square;
  }
};

/// Pairs, fits the numbers to the pairs, and pairs again with the model that they make, until the pairs stay
/// and the modulus that springs are told at has settled.
template <class Identify>
Trial fit_from(fem::Body body, int elements, Kind law, const std::vector<std::string>& free,
               const Identify& identify) {
  Trial trial{identify(body), {}, std::move(body), 0.0};
  for (int round = 0; round < most_rounds; ++round) {
    JointFit joint = fit_body_numbers(fem::assemble(trial.body, elements), trial.found.eigenmodes,
                                      trial.found.rigid, trial.found.pairs, law, free);
    trial.fitted = std::move(joint.fitted);
    trial.chi_square = joint.chi_square;
    if (!trial.fitted.inseparable.empty()) break;
    trial.body = std::move(joint.body);
    Identified next = identify(trial.body);
    keep_ratio(trial.body, free, next.parameters.modulus.laws.front().law);
    const bool settled = same_pairs(trial.found.pairs, next.pairs);
    trial.found = std::move(next);
    if (settled) break;
  }
  return trial;
}

/// The best of what several compliances of supports that do not give yet lead to: softer ones pair other
/// modes.
template <class Identify>
Trial best_fit(const fem::Body& scene, int elements, Kind law, const std::vector<std::string>& free,
               const Identify& identify) {
  const bool rigid = std::any_of(free.begin(), free.end(), [&](const std::string& name) {
    return !std::isfinite(fem::fittable_number(scene, name).value);
  });
  std::optional<Trial> best;
  for (const double compliance : {3e-3, 1e-4, 3e-2}) {
    Trial trial = fit_from(with_finite_supports(scene, free, compliance), elements, law, free, identify);
    if (!best || trial.is_better_than(*best)) best = std::move(trial);
    if (!rigid) break;
  }
  return std::move(*best);
}

/// Drops what the modes do not tell, one by one, and fits the rest.
IdentifiedParameters identify_with_numbers(const ModeSet& measured, const fem::Model& model,
                                           const fem::Drive& drive, const fem::Measurement& measurement,
                                           FitOptions options) {
  const int elements = static_cast<int>(model.arc_length.size()) - 1;
  if (options.modulus_law.empty()) options.modulus_law = "power";
  const Kind law = fitted_law(options.modulus_law);
  check_joint_law(law);
  const auto identify_fitted = [&](const fem::Body& body, const FittedNumbers& fitted) {
    return identify_material(measured, fem::assemble(body, elements), drive, measurement, options, fitted);
  };
  const auto identify = [&](const fem::Body& body) { return identify_fitted(body, {}); };
  fem::Body scene = model.body;
  scene.material.youngs_modulus = identify(scene).parameters.modulus.laws.front().law;
  std::vector<std::string> free = options.free;
  FittedNumbers left;
  while (!free.empty()) {
    Trial trial = best_fit(scene, elements, law, free, identify);
    FittedNumbers& fitted = trial.fitted;
    if (fitted.inseparable.empty()) {
      for (std::size_t k = 0; k < free.size(); ++k)
        fitted.value[static_cast<Eigen::Index>(k)] = fem::fittable_number(trial.body, free[k]).value;
      IdentifiedParameters result = identify_fitted(trial.body, fitted).parameters;
      result.fitted.inseparable = std::move(left.inseparable);
      return result;
    }
    if (left.condition == 0.0) left.condition = fitted.condition;
    left.inseparable.push_back(fitted.inseparable.front());
    std::erase(free, left.inseparable.back().name);
  }
  // Nothing is told of the body: what a fit without its numbers finds.
  IdentifiedParameters result = identify(model.body).parameters;
  result.fitted = std::move(left);
  return result;
}

}  // namespace

IdentifiedParameters identify_parameters(const ModeSet& measured, const fem::Model& model,
                                         const fem::Drive& drive, const fem::Measurement& measurement,
                                         const FitOptions& options) {
  validate(options);
  if (options.free.empty())
    return identify_material(measured, model, drive, measurement, options, {}).parameters;
  return identify_with_numbers(measured, model, drive, measurement, options);
}

fem::Material apply(const IdentifiedParameters& identified, fem::Material material) {
  if (!identified.modulus.laws.empty()) material.youngs_modulus = identified.modulus.laws.front().law;
  if (!identified.loss_factor.laws.empty()) material.loss_factor = identified.loss_factor.laws.front().law;
  if (identified.rayleigh_known) material.rayleigh = identified.rayleigh.rayleigh;
  return material;
}

fem::Body apply(const IdentifiedParameters& identified, fem::Body body) {
  body.material = apply(identified, std::move(body.material));
  const FittedNumbers& fitted = identified.fitted;
  for (std::size_t k = 0; k < fitted.name.size(); ++k) {
    fem::BodyNumber number = fem::fittable_number(body, fitted.name[k]);
    const double value = fitted.value[static_cast<Eigen::Index>(k)];
    if (number.section.torsion_constant == 0.0) number.value = value;  // a support's may be infinite
    body = fem::moved(body, number, value - number.value);
  }
  return body;
}

}  // namespace struna::ident
