#include "ident/parameter_identification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"

namespace struna::ident {
namespace {

using Kind = fem::FrequencyLaw::Kind;

constexpr double unknown_modulus_sigma = 5e-3;  // relative, where the modes have no standard errors
constexpr double unknown_loss_factor_sigma = 5e-2;
constexpr double worst_modulus_sigma = 0.02;  // relative; a mode known worse than this says nothing
constexpr double worst_loss_factor_sigma = 0.10;
constexpr double poor_circle_sigma =
    0.03;  // relative, of a loss factor from a multi-mode fit whose circle is poor
constexpr double separate_enough = 0.5;  // bandwidths between neighbours whose loss factors can be told apart
constexpr double one_resonance =
    0.05;  // bandwidths between two modes that widen their common pole too little to matter
constexpr double close_frequency_error =
    0.05;  // bandwidths, of a frequency read off a circle shared with a neighbour

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
}

/// The eigenvalue that an infinitely fine mesh would have. A mesh of cubic elements of length h is too stiff
/// in bending: f_h/f - 1 = (b h)^4/1440, b^4 = rho A omega^2/(E I); left in, it would read as a modulus that
/// is too low (0.2 % at ten elements per three half waves). It is for bending modes; axial and torsional ones
/// lie above the bands that are measured.
double without_mesh_error(double eigenvalue, const fem::Model& model) {
  const fem::Body& body = model.body;
  const double h = model.arc_length.back() / static_cast<double>(model.arc_length.size() - 1);
  const double b4 = body.density * body.section.area * eigenvalue / body.section.second_moment;
  return eigenvalue / std::pow(1.0 + b4 * std::pow(h, 4) / 1440.0, 2);
}

/// The elastic modes, which alone resonate, and how many rigid ones come before them.
struct Elastic {
  ModelModes modes;
  long rigid = 0;
};

Elastic elastic_modes(const fem::Model& model, const fem::Drive& drive, const fem::Measurement& measurement,
                      std::size_t measured_count) {
  // Four times the measured ones: missing modes, out-of-plane ones that the drive hardly reaches, and room
  // above the band.
  const fem::Eigenmodes all = fem::solve_eigenmodes(model, 4 * static_cast<int>(measured_count) + 20);
  const long rigid = fem::rigid_modes(model.body, all.eigenvalue);
  const long elastic = all.eigenvalue.size() - rigid;
  const fem::Eigenmodes modes{all.eigenvalue.tail(elastic), all.shape.rightCols(elastic)};
  ModelModes result;
  result.eigenvalue = modes.eigenvalue.unaryExpr([&](double v) { return without_mesh_error(v, model); });
  result.constant = fem::modal_constants(model, modes, drive, measurement, fem::constant_law(1.0));
  result.constant_scales_with_modulus = std::holds_alternative<fem::SupportMotion>(drive) ||
                                        std::holds_alternative<fem::SupportForce>(measurement.what);
  return {result, rigid};
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

/// Distance to the nearest other measured mode, in half-power bandwidths.
double neighbour_distance(const std::vector<Mode>& modes, std::size_t mine) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < modes.size(); ++j) {
    if (j == mine) continue;
    const double distance = std::abs(modes[j].natural_frequency_hz - modes[mine].natural_frequency_hz);
    nearest = std::min(nearest, distance);
  }
  return nearest / (modes[mine].loss_factor * modes[mine].natural_frequency_hz);
}

/// A multi-mode fit has taken the neighbours out: it has standard errors and its values are not the circle's
/// own.
bool is_refined(const Mode& mode) {
  return std::isfinite(mode.loss_factor_sigma) &&
         mode.circle_natural_frequency_hz != mode.natural_frequency_hz;
}

/// Why neither the modulus nor the loss factor can be had from this mode.
std::optional<std::string> distrust_both(const Mode& mode) {
  if (mode.has(ModeFlag::not_converged)) return "not_converged: its fit did not settle";
  if (mode.has(ModeFlag::edge)) return "edge: its half-power band reaches past the band analysed";
  return std::nullopt;
}

std::optional<std::string> distrust_modulus(double relative_sigma) {
  if (relative_sigma > worst_modulus_sigma) {
    return fmt::format("modulus: known to {:.1f} % only, more than {:.0f} %", 100.0 * relative_sigma,
                       100.0 * worst_modulus_sigma);
  }
  return std::nullopt;
}

std::optional<std::string> distrust_loss_factor(const Pair& pair, const Mode& mode, double spread,
                                                double neighbour) {
  if (!(mode.loss_factor > 0.0) || !std::isfinite(mode.loss_factor)) {
    return fmt::format("loss factor: must be positive, got {}", mode.loss_factor);
  }
  if (mode.has(ModeFlag::coarse)) return "loss factor: coarse: too few lines in the half-power band";
  if (mode.has(ModeFlag::poor_circle) && !is_refined(mode)) {
    return "loss factor: poor_circle: not the circle of one mode";
  }
  if (spread > one_resonance) {
    return fmt::format("loss factor: one pole for two modes {:.2f} bandwidths apart", spread);
  }
  if (mode.has(ModeFlag::double_mode) && pair.model.size() < 2) {
    return "loss factor: double_mode: one pole for two modes that the model does not have";
  }
  if (mode.has(ModeFlag::close_modes)) {
    if (!is_refined(mode)) return "loss factor: close_modes: the circle is not this mode's own";
    if (neighbour < separate_enough) {
      return fmt::format("loss factor: close_modes: a neighbour {:.2f} bandwidths away", neighbour);
    }
  }
  if (mode.loss_factor_sigma > worst_loss_factor_sigma * mode.loss_factor) {
    return fmt::format("loss factor: noisy: known to {:.0f} % only, more than {:.0f} %",
                       100.0 * mode.loss_factor_sigma / mode.loss_factor, 100.0 * worst_loss_factor_sigma);
  }
  return std::nullopt;
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

double relative_modulus_sigma(const Pair& pair, const Mode& mode, const FitOptions& options) {
  double sigma = pair.modulus_sigma / pair.modulus;
  if (!std::isfinite(mode.natural_frequency_sigma)) sigma = std::hypot(sigma, unknown_modulus_sigma);
  if (mode.has(ModeFlag::close_modes) && !is_refined(mode)) {
    sigma = std::hypot(sigma, 2.0 * close_frequency_error * mode.loss_factor);
  }
  return std::hypot(sigma, options.modulus_floor);
}

double relative_loss_factor_sigma(const Mode& mode, const FitOptions& options) {
  const double given = mode.loss_factor_sigma / mode.loss_factor;
  const double relative = std::isfinite(given) ? given : unknown_loss_factor_sigma;
  const double doubt = mode.has(ModeFlag::poor_circle) ? poor_circle_sigma : 0.0;
  return std::hypot(relative, doubt, options.loss_factor_floor);
}

/// Sorts the pairs' moduli and loss factors (as read, not yet freed of the rising modulus) into the trusted
/// and the rejected.
void sort_by_trust(const Selection& selection, const Pairing& pairing, const FitOptions& options,
                   Points& modulus, Points& loss_factor, std::vector<LeftOut>& rejected) {
  for (const Unpaired& unpaired : pairing.left_out) {
    const double f = selection.set.modes[static_cast<std::size_t>(unpaired.measured)].natural_frequency_hz;
    rejected.push_back({f, unpaired.reason, LeftOutOf::both});
  }
  for (const Pair& pair : pairing.pairs) {
    const auto i = static_cast<std::size_t>(pair.measured);
    const Mode& mode = selection.set.modes[i];
    const double f = mode.natural_frequency_hz;
    if (const auto reason = distrust_both(mode)) {
      rejected.push_back({f, *reason, LeftOutOf::both});
      continue;
    }
    const double sigma = relative_modulus_sigma(pair, mode, options);
    if (const auto reason = distrust_modulus(sigma)) {
      rejected.push_back({f, *reason, LeftOutOf::modulus});
    } else {
      modulus.add(f, pair.modulus, sigma * pair.modulus);
    }
    const double spread = mode.loss_factor > 0.0 ? pair.spread / mode.loss_factor : 0.0;
    if (const auto reason =
            distrust_loss_factor(pair, mode, spread, neighbour_distance(selection.set.modes, i))) {
      rejected.push_back({f, *reason, LeftOutOf::loss_factor});
    } else {
      loss_factor.add(f, mode.loss_factor, relative_loss_factor_sigma(mode, options) * mode.loss_factor);
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

IdentifiedParameters identify_parameters(const ModeSet& measured, const fem::Model& model,
                                         const fem::Drive& drive, const fem::Measurement& measurement,
                                         const FitOptions& options) {
  validate(options);
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
  const Elastic model_side = elastic_modes(model, drive, measurement, selection.set.modes.size());
  result.pairing = pair_modes(selection.set, model_side.modes, pairing_options);

  Points modulus, loss_factor;
  sort_by_trust(selection, result.pairing, options, modulus, loss_factor, result.rejected);
  if (modulus.value.empty()) throw Error(nothing_paired(selection.set, result.pairing));
  to_list_indices(result.pairing, selection.index, static_cast<int>(model_side.rigid));
  result.modulus = modulus.curve();
  result.modulus.laws = fit_curve_laws(
      result.modulus, {Kind::constant, Kind::power, Kind::fractional_zener, Kind::monotone_spline}, true,
      options.modulus_law, "modulus");

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
  return result;
}

fem::Material apply(const IdentifiedParameters& identified, fem::Material material) {
  if (!identified.modulus.laws.empty()) material.youngs_modulus = identified.modulus.laws.front().law;
  if (!identified.loss_factor.laws.empty()) material.loss_factor = identified.loss_factor.laws.front().law;
  if (identified.rayleigh_known) material.rayleigh = identified.rayleigh.rayleigh;
  return material;
}

}  // namespace struna::ident
