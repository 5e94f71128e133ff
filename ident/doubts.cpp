#include "ident/doubts.hpp"

#include <algorithm>
#include <cmath>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

constexpr int least_pairs = 3;              // fewer say nothing of a pattern
constexpr double agreeing_share = 0.75;     // of the pairs, below which shapes are doubted
constexpr double gross_share = 0.5;         // … and disbelieved
constexpr double unpaired_share = 0.25;     // of the sound modes, above which
constexpr double unseen_share = 1.0 / 3.0;  // of paired and unseen model modes, above which
constexpr double visible_strength = 0.5;    // of the paired modes' median |C|/lambda
constexpr double open_odds = 0.05;          // of other pairs than those found, above which
constexpr double least_offset_db = 2.0;     // calibrations are not better
constexpr double offset_scatter = 3.0;      // standard deviations of a mode's level that an offset exceeds
constexpr double misfit_sigma = 3.0;        // rms over sigma of a law
constexpr double usual_slope = 0.1;         // of ln E over ln f, of wires: no more
constexpr double least_frac = 0.85;         // of what noise leaves possible
constexpr double weak_output = 0.1;         // of the strongest output: cross-talk, of which nothing is asked
constexpr double viscous_margin = 0.9;      // of the structural model's level error, below which
constexpr double rayleigh_margin =
    0.5;  // of the other laws' rms, below which Rayleigh's line is plainly better

/// The modes that the fit looked at, their places in the list, and the pairing in their and the elastic
/// modes' count.
struct View {
  ModeSet modes;
  Pairing pairing;
};

View view_of(const ModeSet& modes, const FitOptions& options, const IdentifiedParameters& identified,
             int rigid) {
  View view{modes, identified.pairing};
  view.modes.modes.clear();
  std::vector<int> place(modes.modes.size(), -1);
  for (std::size_t i = 0; i < modes.modes.size(); ++i) {
    const double f = modes.modes[i].natural_frequency_hz;
    if (options.band_hi_hz > 0.0 && (f < options.band_lo_hz || f > options.band_hi_hz)) continue;
    place[i] = static_cast<int>(view.modes.modes.size());
    view.modes.modes.push_back(modes.modes[i]);
  }
  for (Pair& pair : view.pairing.pairs) {
    pair.measured = place[static_cast<std::size_t>(pair.measured)];
    for (int& mode : pair.model) mode -= rigid;
  }
  for (int& mode : view.pairing.missing) mode -= rigid;
  return view;
}

PairingOptions pairing_options(const FitOptions& options) {
  PairingOptions result = options.pairing;
  if (options.band_hi_hz > 0.0) {
    result.band_lo_hz = options.band_lo_hz;
    result.band_hi_hz = options.band_hi_hz;
  }
  return result;
}

/// Model modes that should have been seen: as strong as the paired ones, and not beside one of them, whose
/// pole may stand for both.
Doubt unseen_modes(const View& view, const ModelModes& model) {
  const auto strength = [&](int r) { return model.constant.row(r).norm() / model.eigenvalue[r]; };
  std::vector<double> paired;
  for (const Pair& pair : view.pairing.pairs) paired.push_back(strength(pair.model.front()));
  Doubt doubt{DoubtKind::modes_unseen, 0, static_cast<int>(paired.size()), 0.0, 0.0, {}, {}};
  if (paired.empty()) return doubt;
  const auto middle = paired.begin() + static_cast<std::ptrdiff_t>(paired.size() / 2);
  std::nth_element(paired.begin(), middle, paired.end());
  for (int r : view.pairing.missing) {
    const bool beside = std::any_of(view.pairing.pairs.begin(), view.pairing.pairs.end(), [&](const Pair& p) {
      const double loss_factor = view.modes.modes[static_cast<std::size_t>(p.measured)].loss_factor;
      return std::any_of(p.model.begin(), p.model.end(), [&](int other) {
        return 0.5 * std::abs(std::log(model.eigenvalue[r] / model.eigenvalue[other])) < loss_factor;
      });
    });
    if (!beside && strength(r) >= visible_strength * *middle) ++doubt.count;
  }
  doubt.of += doubt.count;
  return doubt;
}

/// Another of the fitted laws that meets the modes, and rises as a wire's may; "" where there is none.
std::string law_that_fits(const IdentifiedCurve& curve) {
  for (const LawFit& fit : curve.laws) {
    if (fit.law.kind != fem::FrequencyLaw::Kind::power || fit.rms > misfit_sigma) continue;
    const double slope = fit.law.log_slope(curve.frequency_hz[0]);
    if (slope >= 0.0 && slope <= usual_slope) return fem::to_string(fit.law.kind);
  }
  return "";
}

std::optional<Doubt> law_doubt(const IdentifiedCurve& curve, const std::string& quantity) {
  if (curve.laws.empty() || curve.value.size() == 0 || curve.laws.front().rms <= misfit_sigma) {
    return std::nullopt;
  }
  const LawFit& fit = curve.laws.front();
  double squares = 0.0;
  for (Eigen::Index i = 0; i < curve.value.size(); ++i) {
    squares += std::pow(curve.value[i] / fit.law.at(curve.frequency_hz[i]) - 1.0, 2);
  }
  const double scatter = std::sqrt(squares / static_cast<double>(curve.value.size()));
  Doubt doubt{DoubtKind::law_misfit,
              static_cast<int>(curve.value.size()),
              static_cast<int>(curve.value.size()),
              fit.rms,
              scatter,
              {quantity, fem::to_string(fit.law.kind)},
              {}};
  if (const std::string other = law_that_fits(curve); quantity == "modulus" && !other.empty())
    doubt.names.push_back(other);
  return doubt;
}

bool has(const std::vector<Doubt>& doubts, DoubtKind kind) {
  return std::any_of(doubts.begin(), doubts.end(), [&](const Doubt& doubt) { return doubt.kind == kind; });
}

}  // namespace

std::string to_string(DoubtKind kind) {
  switch (kind) {
    case DoubtKind::shapes_disagree:
      return "shapes_disagree";
    case DoubtKind::modes_unpaired:
      return "modes_unpaired";
    case DoubtKind::modes_unseen:
      return "modes_unseen";
    case DoubtKind::pairing_open:
      return "pairing_open";
    case DoubtKind::sign_reversed:
      return "sign_reversed";
    case DoubtKind::level_offset:
      return "level_offset";
    case DoubtKind::law_misfit:
      return "law_misfit";
    case DoubtKind::low_frac:
      return "low_frac";
    case DoubtKind::scatter_differs:
      return "scatter_differs";
    case DoubtKind::viscous_closer:
      return "viscous_closer";
  }
  throw Error("to_string: no such DoubtKind");
}

std::vector<Doubt> identification_doubts(const ModeSet& modes, const fem::Model& model,
                                         const fem::Drive& drive, const fem::Measurement& measurement,
                                         const FitOptions& options, const IdentifiedParameters& identified) {
  std::vector<Doubt> doubts;
  const int count = modes_to_solve(modes.modes.size());
  const ElasticModes elastic = elastic_modes(model, drive, measurement, count);
  const View view = view_of(modes, options, identified, elastic.rigid);
  const ShapeAgreement now = shape_agreement(view.modes, elastic.modes, view.pairing);
  const int unpaired = now.modes - now.pairs;

  if (now.pairs >= least_pairs && now.agreeing < agreeing_share * now.pairs) {
    doubts.push_back(
        {DoubtKind::shapes_disagree, now.agreeing, now.pairs, now.median_mac, 0.0, modes.outputs, {}});
  }
  if (unpaired >= least_pairs && unpaired > unpaired_share * now.modes) {
    doubts.push_back({DoubtKind::modes_unpaired, unpaired, now.modes, 0.0, 0.0, modes.outputs, {}});
  }
  if (!doubts.empty()) {
    doubts.front().remedy = find_remedy(view.modes, model, drive, measurement, pairing_options(options), now);
  }
  const bool explained = !doubts.empty() && doubts.front().remedy;
  const RivalPairing& rival = identified.pairing.rival;
  if (!explained && rival.odds > open_odds) {
    doubts.push_back({DoubtKind::pairing_open,
                      static_cast<int>(view.pairing.pairs.size()),
                      static_cast<int>(view.modes.modes.size()),
                      rival.modulus,
                      rival.odds,
                      {},
                      {}});
  }
  if (identified.pairing.sign_reversed && !explained) {
    doubts.push_back({DoubtKind::sign_reversed, 0, 0, 0.0, 0.0, {}, {}});
  }
  const Doubt unseen = unseen_modes(view, elastic.modes);
  if (unseen.count >= least_pairs && unseen.count > unseen_share * unseen.of) doubts.push_back(unseen);

  const double offset_db = std::abs(20.0 * std::log10(now.level));
  if (now.pairs >= least_pairs && !has(doubts, DoubtKind::shapes_disagree) && offset_db > least_offset_db &&
      offset_db > offset_scatter * now.level_scatter_db) {
    doubts.push_back({DoubtKind::level_offset, now.pairs, now.pairs, now.level, 0.0, {}, {}});
  }
  if (const auto doubt = law_doubt(identified.modulus, "modulus")) doubts.push_back(*doubt);
  // Modes read as viscous are damped by alpha and beta: the law of their loss factor is for information.
  if (modes.damping == fem::Damping::structural) {
    if (const auto doubt = law_doubt(identified.loss_factor, "loss factor")) doubts.push_back(*doubt);
  }
  return doubts;
}

std::vector<Doubt> comparison_doubts(const Comparison& structural, const Comparison& viscous,
                                     const ModeSet& modes, const IdentifiedParameters& identified,
                                     const std::vector<Doubt>& identification) {
  std::vector<Doubt> doubts;
  double strongest = 0.0;
  for (const OutputComparison& output : structural.outputs) {
    strongest = std::max(strongest, output.measured_rms);
  }
  Doubt low{DoubtKind::low_frac, 0, 0, 1.0, 1.0, {}, {}};
  for (std::size_t k = 0; k < structural.outputs.size(); ++k) {
    const OutputComparison& output = structural.outputs[k];
    double frac = output.frac;
    if (k < viscous.outputs.size()) frac = std::max(frac, viscous.outputs[k].frac);
    const double possible = 1.0 - output.noise_share;
    const bool asked = is_defined(output) && output.measured_rms >= weak_output * strongest;
    if (!asked || frac >= least_frac * possible) continue;
    low.names.push_back(output.output);
    if (frac < low.value) {
      low.value = frac;
      low.other = possible;
    }
  }
  if (!low.names.empty()) doubts.push_back(low);

  if (modes.damping != fem::Damping::structural || question_the_model(identification) ||
      !identified.rayleigh_known || !low.names.empty()) {
    return doubts;
  }
  const double error = mean_level_error_db(structural);
  const double viscous_error = mean_level_error_db(viscous);
  // Damping that two Rayleigh coefficients explain, and no constant or power of the frequency does.
  double other_rms = 1e300;
  for (const LawFit& fit : identified.loss_factor.laws) {
    if (fit.law.kind == fem::FrequencyLaw::Kind::monotone_spline) continue;
    other_rms = std::min(other_rms, fit.rms);
  }
  const bool rayleigh_explains = identified.loss_factor.value.size() >= least_pairs &&
                                 identified.rayleigh.rms < misfit_sigma && other_rms > misfit_sigma &&
                                 identified.rayleigh.rms < rayleigh_margin * other_rms;
  if (viscous_error < viscous_margin * error || (rayleigh_explains && viscous_error <= error)) {
    doubts.push_back({DoubtKind::viscous_closer, 0, 0, error, viscous_error, {}, {}});
  }
  return doubts;
}

bool question_the_model(const std::vector<Doubt>& doubts) {
  return std::any_of(doubts.begin(), doubts.end(), [](const Doubt& doubt) {
    return doubt.kind == DoubtKind::shapes_disagree || doubt.kind == DoubtKind::modes_unpaired ||
           doubt.kind == DoubtKind::modes_unseen || doubt.kind == DoubtKind::pairing_open ||
           doubt.kind == DoubtKind::sign_reversed || doubt.kind == DoubtKind::level_offset ||
           doubt.kind == DoubtKind::low_frac;
  });
}

bool shapes_disagree_grossly(const std::vector<Doubt>& doubts) {
  return std::any_of(doubts.begin(), doubts.end(), [](const Doubt& doubt) {
    return doubt.kind == DoubtKind::shapes_disagree && doubt.count <= gross_share * doubt.of;
  });
}

void withdraw_trust(IdentifiedParameters& identified) {
  std::vector<double> trusted;
  for (const IdentifiedCurve* curve : {&identified.modulus, &identified.loss_factor}) {
    trusted.insert(trusted.end(), curve->frequency_hz.begin(), curve->frequency_hz.end());
  }
  std::sort(trusted.begin(), trusted.end());
  trusted.erase(std::unique(trusted.begin(), trusted.end()), trusted.end());
  std::erase_if(identified.rejected, [&](const LeftOut& left_out) {
    return std::binary_search(trusted.begin(), trusted.end(), left_out.frequency_hz);
  });
  for (double f : trusted) {
    identified.rejected.push_back(
        {f, "the modes' shapes disagree with the model's: no pair is trusted", LeftOutOf::both});
  }
  std::stable_sort(identified.rejected.begin(), identified.rejected.end(),
                   [](const LeftOut& a, const LeftOut& b) { return a.frequency_hz < b.frequency_hz; });
  for (IdentifiedCurve* curve : {&identified.modulus, &identified.loss_factor}) {
    curve->frequency_hz.resize(0);
    curve->value.resize(0);
    curve->sigma.resize(0);
  }
  identified.kramers_kronig_loss_factor.resize(0);
}

}  // namespace struna::ident
