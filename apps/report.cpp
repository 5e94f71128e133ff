#include "apps/report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/report_files.hpp"
#include "apps/report_page.hpp"
#include "apps/scene_fit.hpp"
#include "fem/error.hpp"
#include "ident/rayleigh_flag.hpp"

namespace struna::apps {

namespace {

using nlohmann::json;

constexpr int curve_points = 160;

json point(const std::complex<double>& value) {
  return {number(value.real()), number(value.imag())};
}

/// A prediction on the measured lines does not repeat them.
json prediction(const ident::TransferFunction& tf, const ident::TransferFunction& measured) {
  json entry = transfer_function_json(tf);
  if (tf.frequency_hz.size() == measured.frequency_hz.size() && tf.frequency_hz == measured.frequency_hz)
    entry.erase("frequency");
  return entry;
}

/// Whether a quantity was identified from the mode: its frequency is among the curve's.
bool used_in(const ident::IdentifiedCurve& curve, const ident::Mode& mode) {
  return (curve.frequency_hz.array() == mode.natural_frequency_hz).any();
}

json circles(const ident::Mode& mode) {
  json list = json::array();
  for (const auto& circle : mode.circles)
    list.push_back({{"centre", point(circle.centre)},
                    {"radius", number(circle.radius)},
                    {"resonance", point(circle.at_resonance)},
                    {"lower", point(circle.at_lower_half_power)},
                    {"upper", point(circle.at_upper_half_power)},
                    {"scatter", number(circle.scatter, 4)}});
  return list;
}

/// The lines in a mode's window, in circle form; for a mode without one, its half-power band and as much on
/// either side.
json nyquist_lines(const ident::Mode& mode, const ident::TransferFunction& circle_form) {
  double lo = mode.window_lo_hz;
  double hi = mode.window_hi_hz;
  if (!(hi > lo)) {
    const double width = mode.upper_half_power_hz - mode.lower_half_power_hz;
    lo = mode.lower_half_power_hz - width;
    hi = mode.upper_half_power_hz + width;
  }
  const auto& f = circle_form.frequency_hz;
  const long first = std::lower_bound(f.begin(), f.end(), lo) - f.begin();
  const long count = std::max(std::upper_bound(f.begin(), f.end(), hi) - f.begin() - first, 0L);
  json outputs = json::array();
  for (const auto& output : circle_form.outputs) {
    const Eigen::VectorXcd value = output.value.segment(first, count);
    outputs.push_back({{"re", numbers(value.real())}, {"im", numbers(value.imag())}});
  }
  return {{"frequency", numbers(Eigen::VectorXd(f.segment(first, count)))}, {"outputs", std::move(outputs)}};
}

json mode_entry(const ident::Mode& mode, const ident::TransferFunction& circle_form,
                const ident::IdentifiedParameters& identified) {
  json flags = json::array();
  for (const auto flag : mode.flags) flags.push_back(to_string(flag));
  json constants = json::array();
  for (const auto& constant : mode.modal_constant) constants.push_back(point(constant));
  return {{"frequency", number(mode.natural_frequency_hz, 9)},
          {"frequencySigma", number(mode.natural_frequency_sigma, 4)},
          {"lower", number(mode.lower_half_power_hz, 9)},
          {"upper", number(mode.upper_half_power_hz, 9)},
          {"lossFactor", number(mode.loss_factor)},
          {"lossFactorSigma", number(mode.loss_factor_sigma, 4)},
          {"dampingRatio", number(mode.damping_ratio)},
          {"constants", std::move(constants)},
          {"constantSigmas", numbers(mode.modal_constant_sigma, 4)},
          {"flags", std::move(flags)},
          {"resolvesFrom", number(mode.resolves_from, 3)},
          {"stableOrders", mode.stable_orders},
          {"orders", mode.orders},
          {"circleFrequency", number(mode.circle_natural_frequency_hz, 9)},
          {"circleLossFactor", number(mode.circle_loss_factor)},
          {"circles", circles(mode)},
          {"lines", nyquist_lines(mode, circle_form)},
          {"usedForModulus", used_in(identified.modulus, mode)},
          {"usedForLossFactor", used_in(identified.loss_factor, mode)}};
}

json rejected_candidates(const std::vector<ident::RejectedCandidate>& list) {
  json entries = json::array();
  for (const auto& entry : list)
    entries.push_back({{"frequency", number(entry.frequency_hz)}, {"reason", entry.reason}});
  return entries;
}

json left_out(const std::vector<ident::LeftOut>& list) {
  json entries = json::array();
  for (const auto& entry : list)
    entries.push_back({{"frequency", number(entry.frequency_hz)},
                       {"reason", entry.reason},
                       {"what", to_string(entry.what)}});
  return entries;
}

json stabilisation(const ident::Stabilisation& found) {
  json order = json::array(), frequency = order, loss_factor = order, stability = order, columns = order;
  for (const ident::OrderPole& pole : found.poles) {
    order.push_back(pole.order);
    frequency.push_back(number(pole.pole.natural_frequency_hz));
    loss_factor.push_back(number(pole.pole.loss_factor, 4));
    stability.push_back(static_cast<int>(pole.stability));
  }
  for (const ident::StableColumn& column : found.columns)
    columns.push_back({{"frequency", number(column.pole.natural_frequency_hz)},
                       {"frequencySpread", number(column.frequency_spread_hz, 4)},
                       {"lossFactor", number(column.pole.loss_factor)},
                       {"lossFactorSpread", number(column.loss_factor_spread, 4)},
                       {"orders", column.orders},
                       {"of", column.of_orders}});
  return {{"order", std::move(order)},
          {"frequency", std::move(frequency)},
          {"lossFactor", std::move(loss_factor)},
          {"stability", std::move(stability)},
          {"columns", std::move(columns)}};
}

json modes(const ReportContent& content) {
  const auto& set = content.modes;
  ident::TransferFunction circle_form;
  if (!set.modes.empty() && content.measured.lines() > 0)
    circle_form = ident::to_circle_form(content.measured, set.damping);
  json list = json::array();
  for (const auto& mode : set.modes) list.push_back(mode_entry(mode, circle_form, content.identified));
  return {{"damping", to_string(set.damping)},
          {"form", to_string(set.form)},
          {"units", set.units},
          {"outputs", set.outputs},
          {"list", std::move(list)},
          {"rejected", rejected_candidates(set.rejected)},
          {"stabilisation", stabilisation(set.stabilisation)}};
}

/// Frequencies at which fitted laws are drawn: the band analysed, evenly in ln f.
Eigen::VectorXd curve_frequencies(const ReportContent& content) {
  double lo = content.identified.provenance.band_lo_hz;
  double hi = content.identified.provenance.band_hi_hz;
  const auto& lines = content.measured.frequency_hz;
  if (!(lo > 0.0 && hi > lo) && lines.size() > 1) {
    lo = lines[0] > 0.0 ? lines[0] : lines[1];
    hi = lines[lines.size() - 1];
  }
  if (!(lo > 0.0 && hi > lo)) return {};
  return Eigen::VectorXd::LinSpaced(curve_points, std::log(lo), std::log(hi)).array().exp();
}

template <typename Law>
json curve(const Eigen::VectorXd& frequency, const Law& law) {
  return numbers(Eigen::VectorXd(frequency.unaryExpr(law)), 6);
}

json identified_curve(const ident::IdentifiedCurve& identified, const Eigen::VectorXd& frequency,
                      const std::vector<ident::BodyErrorStep>& errors = {}) {
  json laws = json::array();
  for (const auto& fit : identified.laws)
    laws.push_back({{"kind", fem::to_string(fit.law.kind)},
                    {"parameters", fit.law.parameters},
                    {"knots", fit.law.frequency},
                    {"knotValues", fit.law.value},
                    {"sigma", numbers(fit.parameter_sigma, 4)},
                    {"aicc", number(fit.aicc)},
                    {"rms", number(fit.rms, 4)},
                    {"from", number(fit.law.valid_from_hz)},
                    {"to", number(fit.law.valid_to_hz)},
                    {"curve", curve(frequency, [&](double f) { return fit.law.at(f); })}});
  if (identified.scene_sigma.size() > 0 && !laws.empty()) {
    laws[0]["sceneSigma"] = curve(
        frequency, [&](double f) { return ident::law_sigma(identified.laws.front().law, errors, false, f); });
  }
  return {{"frequency", numbers(identified.frequency_hz)},
          {"value", numbers(identified.value)},
          {"sceneSigma", numbers(identified.scene_sigma, 4)},
          {"sigma", numbers(identified.sigma, 4)},
          {"laws", std::move(laws)}};
}

json rayleigh(const ident::RayleighFit& fit, const Eigen::VectorXd& frequency) {
  json entry = {{"determined", fit.determined},           {"alpha", number(fit.rayleigh.alpha)},
                {"beta", number(fit.rayleigh.beta)},      {"alphaSigma", number(fit.alpha_sigma, 4)},
                {"betaSigma", number(fit.beta_sigma, 4)}, {"alphaAtBound", fit.alpha_at_bound},
                {"betaAtBound", fit.beta_at_bound},       {"rms", number(fit.rms, 4)},
                {"misfit", number(fit.misfit, 2)},        {"flag", to_string(ident::rayleigh_flag(fit))}};
  entry["curve"] = curve(frequency, [&](double f) { return fem::rayleigh_damping_ratio(fit.rayleigh, f); });
  return entry;
}

json pairing(const ident::Pairing& pairing) {
  json pairs = json::array();
  for (const auto& pair : pairing.pairs)
    pairs.push_back({{"measured", pair.measured},
                     {"model", pair.model},
                     {"mac", number(pair.mac, 5)},
                     {"modulus", number(pair.modulus)},
                     {"sigma", number(pair.modulus_sigma, 4)}});
  json left_out = json::array();
  for (const auto& entry : pairing.left_out)
    left_out.push_back({{"measured", entry.measured}, {"reason", entry.reason}});
  return {{"pairs", std::move(pairs)},
          {"leftOut", std::move(left_out)},
          {"missing", pairing.missing},
          {"signReversed", pairing.sign_reversed},
          {"modulusAt1Hz", number(pairing.modulus_at_1_hz)},
          {"slope", number(pairing.modulus_slope)}};
}

json scene_errors(const ident::IdentifiedParameters& parameters) {
  json list = json::array();
  for (const auto& step : parameters.errors)
    if (!step.is_fitted()) list.push_back({step.of, number(step.level, 4)});
  return list;
}

/// What was fitted of the body beside the modulus, and what could not be.
std::vector<std::string> body_lines(const ident::IdentifiedParameters& parameters) {
  std::vector<std::string> lines = fitted_lines(parameters);
  for (std::string& line : inseparable_lines(parameters)) lines.push_back(std::move(line));
  return lines;
}

json identified(const ReportContent& content) {
  const auto& parameters = content.identified;
  const Eigen::VectorXd frequency = curve_frequencies(content);
  const auto& source = parameters.provenance;
  return {{"body", parameters.body},
          {"curveFrequency", numbers(frequency)},
          {"rayleighKnown", parameters.rayleigh_known},
          {"rayleigh", rayleigh(parameters.rayleigh, frequency)},
          {"modulus", identified_curve(parameters.modulus, frequency, parameters.errors)},
          {"lossFactor", identified_curve(parameters.loss_factor, frequency)},
          {"kramersKronig", numbers(parameters.kramers_kronig_loss_factor)},
          {"sceneErrors", scene_errors(parameters)},
          {"fittedLines", body_lines(parameters)},
          {"rejected", left_out(parameters.rejected)},
          {"pairing", pairing(parameters.pairing)},
          {"version", source.program_version},
          {"date", source.date},
          {"inputs", text_pairs(source.inputs)},
          {"band", {number(source.band_lo_hz), number(source.band_hi_hz)}}};
}

json comparison(const ident::Comparison& comparison) {
  json outputs = json::array();
  for (const auto& output : comparison.outputs) {
    json peaks = json::array();
    for (const auto& peak : output.peaks)
      peaks.push_back({number(peak.measured_hz), number(peak.predicted_hz), number(peak.amplitude_db, 5)});
    outputs.push_back({{"output", output.output},
                       {"frac", number(output.frac)},
                       {"error", number(output.log_magnitude_error_db, 5)},
                       {"mean", number(output.mean_db, 5)},
                       {"largest", number(output.largest_db, 5)},
                       {"peaks", std::move(peaks)}});
  }
  return {{"lo", number(comparison.lo_hz)},
          {"hi", number(comparison.hi_hz)},
          {"meanError", number(ident::mean_level_error_db(comparison), 5)},
          {"outputs", std::move(outputs)},
          {"notCompared", comparison.not_compared}};
}

json sentences(const std::vector<ident::Doubt>& doubts) {
  json list = json::array();
  for (const auto& doubt : doubts) list.push_back(ident::sentence(doubt));
  return list;
}

json page_data(const ReportContent& content) {
  return {{"title", content.title},
          {"command", content.command},
          {"doubts", sentences(content.doubts)},
          {"modelInQuestion", ident::question_the_model(content.doubts)},
          {"warnings", content.warnings},
          {"settings", text_pairs(content.settings)},
          {"measured", transfer_function_json(content.measured)},
          {"predicted", prediction(content.predicted, content.measured)},
          {"viscous", prediction(content.predicted_viscous, content.measured)},
          {"modes", modes(content)},
          {"identified", identified(content)},
          {"comparison", comparison(content.comparison)},
          {"comparisonViscous", comparison(content.comparison_viscous)},
          {"modelFrequencies", numbers(content.model_natural_frequency_hz)},
          {"inputFiles", text_pairs(content.input_files)}};
}

}  // namespace

std::string render_report(const ReportContent& content) {
  static const std::vector<PageSection> sections = {{"summary", "Result"},
                                                    {"transfer", "Transfer functions"},
                                                    {"comparison", "Prediction against measurement"},
                                                    {"parameters", "Modulus and damping over frequency"},
                                                    {"modes", "Modes"},
                                                    {"stabilisation", "Stabilisation"},
                                                    {"nyquist", "Nyquist circles"},
                                                    {"left-out", "Left out, and why"},
                                                    {"provenance", "Settings, inputs, how to reproduce"}};
  return render_page(content.title, sections, page_data(content), report_js);
}

}  // namespace struna::apps
