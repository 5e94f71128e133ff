#include "ident/doubts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

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
constexpr double least_offset_db = 2.0;     // calibrations are not better
constexpr double offset_scatter = 3.0;      // standard deviations of a mode's level that an offset exceeds
constexpr double misfit_sigma = 3.0;        // rms over sigma of a law
constexpr double least_frac = 0.85;         // of what noise leaves possible
constexpr double weak_output = 0.1;         // of the strongest output: cross-talk, of which nothing is asked
constexpr double viscous_margin = 0.9;      // of the structural model's level error, below which
constexpr double rayleigh_margin =
    0.5;  // of the other laws' rms, below which Rayleigh's line is plainly better

struct KnownFactor {
  double factor;
  const char* meaning;
};
constexpr KnownFactor known_factors[] = {
    {1000.0, "mm taken for m, mN for N, or g/cm^3 for kg/m^3"},
    {1e6, "um taken for m, or two of mm for m and mN for N"},
    {9.80665, "g taken for m/s^2, or kgf for N"},
    {4.4482216, "lbf taken for N"},
    {39.3701, "inches taken for m"},
    {25.4, "inches taken for mm"},
    {2.0, "diameter taken for radius or peak-to-peak for amplitude, perhaps"},
    {10.0, "an amplifier's range, perhaps"},
    {100.0, "an amplifier's range, perhaps"},
};
constexpr double factor_tolerance = 0.05;

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
  return Doubt{DoubtKind::law_misfit,
               static_cast<int>(curve.value.size()),
               static_cast<int>(curve.value.size()),
               fit.rms,
               scatter,
               {quantity, fem::to_string(fit.law.kind)},
               {}};
}

bool has(const std::vector<Doubt>& doubts, DoubtKind kind) {
  return std::any_of(doubts.begin(), doubts.end(), [&](const Doubt& doubt) { return doubt.kind == kind; });
}

// ---- sentences

std::string name_of(const std::vector<std::string>& names, int output) {
  const auto k = static_cast<std::size_t>(output);
  return k < names.size() ? names[k] : fmt::format("output {}", output + 1);
}

std::string axis_name(const Eigen::Vector3d& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return std::string(1, "xyz"[axis]);
}

std::string remedy_sentence(const Remedy& remedy, const std::vector<std::string>& names) {
  const ShapeAgreement& then = remedy.agreement;
  const std::string result = fmt::format("{} of {} modes would agree (median MAC {:.3f})", then.agreeing,
                                         then.modes, then.median_mac);
  switch (remedy.change) {
    case Remedy::Change::output_reversed: {
      const std::string name = name_of(names, remedy.outputs.front());
      return fmt::format(
          "; with {0} reversed {1}: check its polarity (sign = -1 in [channel.{0}] of a study), "
          "or whether the scene is mirrored along it",
          name, result);
    }
    case Remedy::Change::outputs_exchanged: {
      std::vector<std::string> moves;
      for (int k = 0; k < static_cast<int>(remedy.outputs.size()); ++k) {
        const int measured_as = remedy.outputs[static_cast<std::size_t>(k)];
        if (measured_as != k) {
          moves.push_back(fmt::format("{} taken for {}", name_of(names, measured_as), name_of(names, k)));
        }
      }
      return fmt::format("; with {} {}: check the cables and the scene's axes", fmt::join(moves, " and "),
                         result);
    }
    case Remedy::Change::driven_along:
      return fmt::format("; driven along {0} {1}: check the direction in the scene's [drive]",
                         axis_name(remedy.direction), result);
  }
  return "";
}

std::string factor_meaning(double factor) {
  const double ratio = std::max(factor, 1.0 / factor);
  for (const KnownFactor& known : known_factors) {
    if (std::abs(ratio / known.factor - 1.0) < factor_tolerance) {
      return fmt::format(" {:.4g} is {};", known.factor, known.meaning);
    }
  }
  return "";
}

std::string level_sentence(const Doubt& doubt) {
  const bool above = doubt.value > 1.0;
  return fmt::format(
      "the measured function is {:.4g} times {} than the model's at all {} paired modes alike ({:+.1f} "
      "dB):{} "
      "check units and sensitivities of input and outputs, and the scene's density and cross-section",
      above ? doubt.value : 1.0 / doubt.value, above ? "larger" : "smaller", doubt.count,
      20.0 * std::log10(doubt.value), factor_meaning(doubt.value));
}

std::string law_sentence(const Doubt& doubt) {
  const std::string& quantity = doubt.names.at(0);
  const std::string start =
      fmt::format("the {} law misses the {} of the modes by {:.2g} % rms, {:.2g} times the standard errors: ",
                  doubt.names.at(1), quantity, 100.0 * doubt.other, doubt.value);
  if (quantity == "modulus") {
    return start +
           "no smooth modulus puts the model's modes where the measured ones are; check end conditions, "
           "geometry "
           "and which modes were paired";
  }
  return start +
         "read the values at the modes, or choose another law (--loss-factor-law, [fit] loss_factor_law)";
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

std::string sentence(const Doubt& doubt) {
  const auto remedy = [&](const char* without) {
    return doubt.remedy ? remedy_sentence(*doubt.remedy, doubt.names) : std::string(without);
  };
  switch (doubt.kind) {
    case DoubtKind::shapes_disagree:
      return fmt::format(
                 "the modes' shapes are not the model's: {} of {} paired modes agree in direction, sign and "
                 "strength over the outputs (median MAC {:.2f})",
                 doubt.count, doubt.of, doubt.value) +
             remedy(
                 "; no single output reversed or exchanged, nor a drive along another axis, mends it: check "
                 "geometry, end conditions, and where the wire is driven and measured");
    case DoubtKind::modes_unpaired:
      return fmt::format("{} of {} sound modes have no counterpart in the model", doubt.count, doubt.of) +
             remedy(
                 ": check end conditions, geometry and drive direction, and whether another structure "
                 "resonates "
                 "in the band");
    case DoubtKind::modes_unseen:
      return fmt::format(
          "{} of {} model modes in the band that should be seen well were not measured: check end "
          "conditions, "
          "geometry and drive direction, and the list of modes (struna modes --add)",
          doubt.count, doubt.of);
    case DoubtKind::sign_reversed:
      return "all modal constants have the sign opposite to the model's: the input's sign, or that of all "
             "outputs, "
             "is likely reversed (sign = -1 in its [channel.NAME] of a study)";
    case DoubtKind::level_offset:
      return level_sentence(doubt);
    case DoubtKind::law_misfit:
      return law_sentence(doubt);
    case DoubtKind::low_frac:
      return fmt::format(
          "the prediction's shape over frequency is not the measured one's: FRAC of {} down to {:.2f}, where "
          "noise "
          "alone would leave {:.2f}: see the comparison of the transfer functions, and check what the other "
          "warnings name, geometry and ends",
          fmt::join(doubt.names, ", "), doubt.value, doubt.other);
    case DoubtKind::scatter_differs:
      return fmt::format(
          "{} of {} modes scatter more over the bootstrap than their standard errors say (ratio {:.2f} "
          "of "
          "all frequencies, {:.2f} of all loss factors): the noise is not steady, or the "
          "structure or set-up changed during or between the records; trust the larger of the two",
          doubt.count, doubt.of, doubt.value, doubt.other);
    case DoubtKind::viscous_closer:
      return fmt::format(
          "the damping looks viscous: the viscous prediction is {:.3g} dB off, the structural one {:.3g} dB: "
          "read "
          "the modes with damping = \"viscous\" (struna modes --damping viscous, [modes] damping of a study)",
          doubt.other, doubt.value);
  }
  throw Error("sentence: no such DoubtKind");
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
  if (identified.pairing.sign_reversed && (doubts.empty() || !doubts.front().remedy)) {
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
           doubt.kind == DoubtKind::modes_unseen || doubt.kind == DoubtKind::sign_reversed ||
           doubt.kind == DoubtKind::level_offset || doubt.kind == DoubtKind::low_frac;
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
