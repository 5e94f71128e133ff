#include "ident/parameter_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <cmath>
#include <sstream>

#include "ident/atomic_file.hpp"
#include "ident/rayleigh_flag.hpp"

namespace struna::ident {

using fem::FrequencyLaw;

std::vector<std::string> parameter_names(FrequencyLaw::Kind kind) {
  using Kind = FrequencyLaw::Kind;
  switch (kind) {
    case Kind::constant:
      return {"value"};
    case Kind::power:
      return {"value", "exponent", "reference_frequency"};
    case Kind::fractional_zener:
      return {"value", "ratio", "relaxation_frequency", "order"};
    case Kind::monotone_spline:
    case Kind::table:
      break;
  }
  return {};
}

namespace {

/// The shortest digits that read back as the same double, marked as a TOML float.
std::string number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

template <class Values>
std::string array(const Values& values) {
  std::vector<std::string> texts;
  for (double value : values) texts.push_back(number(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}

std::string law_lines(const LawFit& fit) {
  const FrequencyLaw& law = fit.law;
  std::string text = fmt::format("kind = \"{}\"\n", fem::to_string(law.kind));
  const std::vector<std::string> names = parameter_names(law.kind);
  for (std::size_t k = 0; k < names.size(); ++k) {
    text += fmt::format("{} = {}\n", names[k], number(law.parameters[k]));
  }
  if (names.empty()) {
    text += fmt::format("frequency = {}\nvalue = {}\n", array(law.frequency), array(law.value));
  }
  text += fmt::format("parameter_sigma = {}  # standard errors, in the order above\n",
                      array(fit.parameter_sigma));
  if (fit.covariance.size() > 0)
    text += fmt::format("covariance = {}  # of the same, row by row\n", array(fit.covariance.reshaped()));
  if (law.valid_to_hz > 0.0) {
    text += fmt::format("valid_from = {}  # Hz, the data's range\nvalid_to = {}\n", number(law.valid_from_hz),
                        number(law.valid_to_hz));
  }
  return text + fmt::format("aicc = {}\nrms = {}\n", number(fit.aicc), number(fit.rms));
}

std::string curve_lines(const std::string& name, const IdentifiedCurve& curve, const std::string& unit,
                        const std::string& extra) {
  std::string text = fmt::format("[{}]\nfrequency = {}  # Hz, measured natural frequencies\n", name,
                                 array(curve.frequency_hz));
  text += fmt::format("value = {}{}\nsigma = {}  # with the model's own error\n", array(curve.value), unit,
                      array(curve.sigma));
  if (curve.scene_sigma.size() > 0)
    text += fmt::format("scene_sigma = {}  # of what the scene states, besides; common to all\n",
                        array(curve.scene_sigma));
  if (curve.fitted_sigma.size() > 0)
    text += fmt::format("fitted_sigma = {}  # of what was fitted of the body, besides; common to all\n",
                        array(curve.fitted_sigma));
  text += extra;
  for (std::size_t k = 0; k < curve.laws.size(); ++k) {
    text += k == 0 ? fmt::format("\n[{}.law]  # what predictions use\n", name)
                   : fmt::format("\n[[{}.other_law]]\n", name);
    text += law_lines(curve.laws[k]);
  }
  return text + "\n";
}

std::string rayleigh_lines(const RayleighFit& fit) {
  return fmt::format(
      "[rayleigh]\nalpha = {}  # 1/s\nbeta = {}  # s\nalpha_sigma = {}\nbeta_sigma = {}\ncovariance = {}\n"
      "rms = {}\nmisfit = {}\nchance = {}\ndetermined = {}\nflag = \"{}\"\n\n",
      number(fit.rayleigh.alpha), number(fit.rayleigh.beta), number(fit.alpha_sigma), number(fit.beta_sigma),
      number(fit.covariance), number(fit.rms), number(fit.misfit), number(fit.chance), fit.determined,
      to_string(rayleigh_flag(fit)));
}

template <class Texts>
std::string text_array(const Texts& texts) {
  std::vector<std::string> words;
  for (const std::string& text : texts) words.push_back(quoted(text));
  return fmt::format("[{}]", fmt::join(words, ", "));
}

std::string fitted_lines(const FittedNumbers& fitted) {
  std::string text;
  if (!fitted.name.empty()) {
    text += fmt::format(
        "[fitted]  # numbers of the body, beside the modulus; they replace the scene's\nnumber = {}\nvalue = "
        "{}\n"
        "sigma = {}\ncovariance = {}  # relative but for masses, row by row\ncondition = {}\n\n",
        text_array(fitted.name), array(fitted.value), array(fitted.sigma()),
        array(fitted.covariance.reshaped()), number(fitted.condition));
  }
  for (const FittedNumbers::Inseparable& left : fitted.inseparable) {
    text += fmt::format(
        "[[inseparable]]  # asked for, and left as the scene has it\nnumber = {}\nreason = {}\n\n",
        quoted(left.name), quoted(left.reason));
  }
  return text;
}

std::string error_lines(const std::vector<BodyErrorStep>& errors) {
  std::string text;
  for (const BodyErrorStep& step : errors) {
    text += fmt::format(
        "[[body_error]]  # one independent error of one sigma, and what follows from it\nof = {}\n",
        quoted(step.of));
    if (!step.is_fitted())
      text += fmt::format("value = {}\nsigma = {}\n", number(step.value), number(step.sigma));
    text += fmt::format(
        "level = {}  # relative, of the modulus\nlaw_step = {}  # of the law's numbers\nnumber = {}\n"
        "change = {}\n\n",
        number(step.level), array(step.law_step), text_array(step.number), array(step.change));
  }
  return text;
}

std::string pair_lines(const Pairing& pairing) {
  std::string text;
  for (const Pair& pair : pairing.pairs) {
    std::vector<int> model = pair.model;
    for (int& mode : model) ++mode;
    text += fmt::format(
        "[[pair]]\nmode = {}\nmodel = [{}]\nmac = {}\nmodulus = {}\nmodulus_sigma = {}  # noise alone\n\n",
        pair.measured + 1, fmt::join(model, ", "), number(pair.mac), number(pair.modulus),
        number(pair.modulus_sigma));
  }
  return text;
}

std::string doubt_lines(const std::vector<Doubt>& doubts) {
  std::string text;
  for (const Doubt& doubt : doubts) {
    text += fmt::format("[[doubt]]\nkind = \"{}\"\ntext = {}\n\n", to_string(doubt.kind),
                        quoted(sentence(doubt)));
  }
  return text;
}

std::string provenance_lines(const Provenance& provenance) {
  std::string text =
      fmt::format("[provenance]\nprogram = \"struna\"\nversion = {}\ndate = {}\nband = [{}, {}]  # Hz\n",
                  quoted(provenance.program_version), quoted(provenance.date), number(provenance.band_lo_hz),
                  number(provenance.band_hi_hz));
  for (const auto& [file, checksum] : provenance.inputs) {
    text += fmt::format("\n[[provenance.input]]\nfile = {}\nsha256 = {}\n", quoted(file), quoted(checksum));
  }
  return text;
}

}  // namespace

std::string law_text(const LawFit& fit, const std::string& unit) {
  const FrequencyLaw& law = fit.law;
  const auto with_unit = [](double value, const std::string& of) {
    return fmt::format("{:.5g}{}{}", value, of.empty() ? "" : " ", of);
  };
  std::vector<std::string> parts;
  const std::vector<std::string> names = parameter_names(law.kind);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const bool frequency = names[k].find("frequency") != std::string::npos;
    const std::string& of = frequency ? "Hz" : names[k] == "value" ? unit : "";
    const auto at = static_cast<Eigen::Index>(k);
    const bool known = at < fit.parameter_sigma.size() && fit.parameter_sigma[at] > 0.0;
    const std::string error = known ? fmt::format(" +- {:.2g}", fit.parameter_sigma[at]) : "";
    parts.push_back(
        fmt::format("{} {:.5g}{}{}{}", names[k], law.parameters[k], error, of.empty() ? "" : " ", of));
  }
  for (std::size_t k = 0; k < law.value.size(); ++k) {
    parts.push_back(with_unit(law.value[k], unit) + " at " + with_unit(law.frequency[k], "Hz"));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void write_parameters(const IdentifiedParameters& identified, const std::string& file,
                      const std::vector<Doubt>& doubts) {
  std::string text = fmt::format("body = {}  # these override its material, and no other body's\n\n",
                                 quoted(identified.body));
  if (!doubts.empty()) text += "# This result is doubted: see [[doubt]] below.\n\n";
  if (identified.rayleigh_known) text += rayleigh_lines(identified.rayleigh);
  text += curve_lines("modulus", identified.modulus, "  # Pa", "");
  if (identified.loss_factor.value.size() > 0 || !identified.loss_factor.laws.empty()) {
    text += curve_lines("loss_factor", identified.loss_factor, "",
                        fmt::format("kramers_kronig = {}  # (pi/2) d ln E/d ln f, for information\n",
                                    array(identified.kramers_kronig_loss_factor)));
  }
  text += fitted_lines(identified.fitted);
  text += error_lines(identified.errors);
  text += pair_lines(identified.pairing);
  for (const LeftOut& left_out : identified.rejected) {
    text += fmt::format("[[rejected]]\nfrequency = {}\nof = \"{}\"\nreason = {}\n\n",
                        number(left_out.frequency_hz), to_string(left_out.what), quoted(left_out.reason));
  }
  text += doubt_lines(doubts);
  text += provenance_lines(identified.provenance);
  write_atomically(file, text);
}

}  // namespace struna::ident
