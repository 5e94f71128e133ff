#include "apps/body_table.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "apps/console.hpp"
#include "apps/curve_warnings.hpp"

namespace struna::apps {
namespace {

/// A number, or { frequency = [...], value = [...] }.
fem::FrequencyLaw read_law(TomlTable& material, const std::string& key, bool allow_zero) {
  if (!material.required(key).is_table()) {
    return fem::constant_law(allow_zero ? material.not_negative(key) : material.positive(key));
  }
  TomlTable entries = material.table(key);
  fem::FrequencyLaw law;
  law.kind = fem::FrequencyLaw::Kind::table;
  law.frequency = entries.numbers("frequency");
  law.value = entries.numbers("value");
  entries.finish();
  try {
    fem::validate(law, "the table", allow_zero);
  } catch (const Error& fault) {
    throw material.error(key, std::string("cannot be used: ") + fault.reason());
  }
  return law;
}

/// The damping that acts must be there when the other one is. Neither: it is to be identified.
void check_damping(TomlTable& material, fem::Damping acting) {
  const bool structural = acting == fem::Damping::structural;
  const std::string needed = structural ? "loss_factor" : "rayleigh";
  const std::string given = structural ? "rayleigh" : "loss_factor";
  if (material.has(given) && !material.has(needed)) {
    throw material.error(
        "damping",
        fmt::format("= \"{}\" needs {}, but only {} is given: give {}, or damping "
                    "= \"{}\"",
                    fem::to_string(acting), needed, given, needed, structural ? "viscous" : "structural"));
  }
}

fem::Material read_material(TomlTable material, bool acts_in_time) {
  fem::Material result;
  if (material.has("youngs_modulus")) result.youngs_modulus = read_law(material, "youngs_modulus", false);
  if (material.has("loss_factor")) result.loss_factor = read_law(material, "loss_factor", true);
  const bool has_rayleigh = material.has("rayleigh");
  if (has_rayleigh) {
    TomlTable rayleigh = material.table("rayleigh");
    result.rayleigh.alpha = rayleigh.not_negative("alpha", 0.0);
    result.rayleigh.beta = rayleigh.not_negative("beta", 0.0);
    rayleigh.finish();
  }
  const bool has_both = has_rayleigh && material.has("loss_factor");
  if (acts_in_time && has_both && !material.has("damping")) {
    throw material.error("damping",
                         "is missing: loss_factor and rayleigh are both given, say which acts in time, "
                         "\"structural\" or \"viscous\"");
  }
  result.damping = material.choice<fem::Damping>(
      "damping", {{"structural", fem::Damping::structural}, {"viscous", fem::Damping::viscous}},
      has_rayleigh && !has_both ? fem::Damping::viscous : fem::Damping::structural);
  if (material.has("damping")) check_damping(material, result.damping);
  material.finish();
  return result;
}

/// The numbers that a cross-section is told by; those that are not are empty.
struct SectionNumbers {
  std::optional<double> diameter, outer_diameter, inner_diameter, area, second_moment, torsion_constant;
};

fem::Section section_of(const SectionNumbers& numbers) {
  fem::Section section;
  if (numbers.diameter) {
    section = fem::solid_circle(*numbers.diameter);
  } else if (numbers.outer_diameter) {
    section = fem::ring(*numbers.outer_diameter, *numbers.inner_diameter);
  } else {
    section.area = *numbers.area;
  }
  section.second_moment = numbers.second_moment.value_or(section.second_moment);
  section.torsion_constant = numbers.torsion_constant.value_or(2.0 * section.second_moment);
  return section;
}

/// The standard deviation beside a number: KEY_sigma, 0 without.
double read_sigma(TomlTable& body, const std::string& key, double value) {
  const std::string sigma_key = key + "_sigma";
  if (!body.has(sigma_key)) return 0.0;
  const double sigma = body.not_negative(sigma_key);
  if (!(sigma < 0.5 * std::abs(value))) {
    throw body.error(sigma_key,
                     fmt::format("must be below half of {} = {}: errors are carried on to first order; "
                                 "got {}",
                                 key, value, sigma));
  }
  return sigma;
}

/// A sigma is of a number that the body states itself.
void check_sigma(TomlTable& body, const std::string& key, bool stated) {
  if (stated || !body.has(key + "_sigma")) return;
  throw body.error(key + "_sigma", "needs " + key + " beside it");
}

/// What the section changes by per unit of each number that tells it.
void state_section(TomlTable& body, const SectionNumbers& numbers, fem::Body& result) {
  const std::vector<std::pair<std::string, std::optional<double> SectionNumbers::*>> all = {
      {"diameter", &SectionNumbers::diameter},
      {"outer_diameter", &SectionNumbers::outer_diameter},
      {"inner_diameter", &SectionNumbers::inner_diameter},
      {"area", &SectionNumbers::area},
      {"second_moment", &SectionNumbers::second_moment},
      {"torsion_constant", &SectionNumbers::torsion_constant}};
  for (const auto& [key, field] : all) {
    const std::optional<double>& value = numbers.*field;
    check_sigma(body, key, value.has_value());
    if (!value) continue;
    fem::BodyNumber number{.name = key, .value = *value, .sigma = read_sigma(body, key, *value)};
    // Polynomials of the fourth degree at most: central differences over 1e-5 leave 1e-10.
    const double step = 1e-5 * *value;
    SectionNumbers more = numbers, less = numbers;
    more.*field = *value + step;
    less.*field = *value - step;
    const fem::Section a = section_of(more), b = section_of(less);
    number.section = {(a.area - b.area) / (2.0 * step), (a.second_moment - b.second_moment) / (2.0 * step),
                      (a.torsion_constant - b.torsion_constant) / (2.0 * step)};
    result.stated.push_back(number);
  }
}

/// Exactly one of: diameter; outer_diameter and inner_diameter; area and second_moment.
SectionNumbers read_section_numbers(TomlTable& body) {
  const std::array<std::string, 3> ways = {"diameter", "outer_diameter", "area"};
  std::string chosen;
  for (const auto& way : ways) {
    if (!body.has(way)) continue;
    if (!chosen.empty()) throw body.error(way, "contradicts " + chosen + ": give one of the two");
    chosen = way;
  }
  if (body.has("inner_diameter") && chosen != "outer_diameter") {
    throw body.error("inner_diameter", chosen.empty() ? "needs outer_diameter beside it"
                                                      : "contradicts " + chosen +
                                                            ": a ring is given by "
                                                            "outer_diameter and inner_diameter");
  }
  if (chosen.empty()) {
    throw body.error(
        "has no cross-section: give diameter, or outer_diameter and inner_diameter, or area and "
        "second_moment" +
        body.misspelling_of("diameter"));
  }
  SectionNumbers numbers;
  if (chosen == "diameter") {
    numbers.diameter = body.positive("diameter");
  } else if (chosen == "outer_diameter") {
    numbers.outer_diameter = body.positive("outer_diameter");
    numbers.inner_diameter = body.positive("inner_diameter");
    if (*numbers.inner_diameter >= *numbers.outer_diameter) {
      throw body.error("inner_diameter", fmt::format("must be below outer_diameter = {}, got {}",
                                                     *numbers.outer_diameter, *numbers.inner_diameter));
    }
  } else {
    numbers.area = body.positive("area");
  }
  if (chosen == "area" || body.has("second_moment")) numbers.second_moment = body.positive("second_moment");
  if (body.has("torsion_constant")) numbers.torsion_constant = body.positive("torsion_constant");
  return numbers;
}

fem::Centreline read_centreline(TomlTable& body) {
  const auto points = body.vectors3("points");
  const double length = body.positive("length", 0.0);
  try {
    return fem::spline_through(points, length);
  } catch (const Error& fault) {
    throw body.error("points", std::string("give no body of positive length: ") + fault.reason());
  }
}

std::string read_body_name(TomlTable& body, const fem::Scene& scene) {
  const std::string name = body.text("name");
  if (name.find_first_of(".@") != std::string::npos) {
    throw body.error(
        "name", "must not contain '.' or '@', which stand before an end or a fraction, got '" + name + "'");
  }
  for (const auto& other : scene.bodies) {
    if (other.name == name) throw body.error("name", "'" + name + "' is taken by an earlier body");
  }
  return name;
}

double read_poisson(TomlTable& body) {
  const double poisson = body.number("poisson", 0.3);
  if (poisson <= -1.0 || poisson > 0.5) {
    throw body.error("poisson", fmt::format("must lie above -1 and not above 0.5, got {}", poisson));
  }
  return poisson;
}

int read_elements(TomlTable& body) {
  const int elements = body.integer("elements", 0);
  // Rounding of the lowest eigenvalue grows with the fourth power: 1e-5 at 1000 (docs/beam_element.md).
  constexpr int most = 1000;
  if (body.has("elements") && (elements < 1 || elements > most)) {
    throw body.error(
        "elements", fmt::format("must be from 1 to {} (or left out, to be chosen): finer meshes lose more to "
                                "rounding than they gain; got {}",
                                most, elements));
  }
  return elements;
}

struct EndTable {
  fem::EndCondition condition = fem::EndCondition::clamped;
  fem::ElasticSupport support;
};

/// "clamped", "pinned", "free", or { translation = N/m, rotation = N m/rad, mass = kg } with a rigid support
/// in what is left out: rotation 0 turns freely, and translation 0 with rotation 0 is a free end.
EndTable read_end(TomlTable& body, const std::string& key, fem::Body& result) {
  using enum fem::EndCondition;
  const toml::node* const node = body.node(key);
  if (node == nullptr || !node->is_table()) {
    return {body.choice<fem::EndCondition>(key, {{"clamped", clamped}, {"pinned", pinned}, {"free", free}},
                                           clamped),
            {}};
  }
  TomlTable table = body.table(key);
  EndTable end;
  const auto stiffness = [&](const std::string& name, double& value) {
    const bool given = table.has(name);
    check_sigma(table, name, given);
    if (!given) return;
    value = table.not_negative(name);
    if (value > 0.0)
      result.stated.push_back(
          {.name = key + "." + name, .value = value, .sigma = read_sigma(table, name, value)});
  };
  stiffness("translation", end.support.translation);
  stiffness("rotation", end.support.rotation);
  stiffness("mass", end.support.mass);
  const bool turns = end.support.rotation == 0.0;
  if (end.support.translation == 0.0) {
    if (!turns) {
      throw table.error("translation",
                        "= 0 lets the end go: say rotation = 0 too, for a free end, as none that only "
                        "turns is held");
    }
    end.condition = free;
    end.support.translation = fem::ElasticSupport{}.translation;
  } else if (turns) {
    end.condition = pinned;
  }
  if (turns) end.support.rotation = fem::ElasticSupport{}.rotation;
  table.finish();
  return end;
}

}  // namespace

fem::Body read_body(TomlTable& table, const fem::Scene& scene, bool acts_in_time, std::vector<Notice>& told) {
  // Read first, put together afterwards: g++ 12 destroys twice what a throwing aggregate initialisation has
  // made.
  const std::string name = read_body_name(table, scene);
  const fem::Centreline centreline = read_centreline(table);
  const SectionNumbers numbers = read_section_numbers(table);
  fem::Body body{.name = name, .centreline = centreline, .section = section_of(numbers), .material = {}};
  state_section(table, numbers, body);
  const double length = centreline.length();
  body.stated.push_back(
      {.name = "length", .value = length, .sigma = read_sigma(table, "length", length), .length = 1.0});
  body.density = table.positive("density");
  body.stated.push_back({.name = "density",
                         .value = body.density,
                         .sigma = read_sigma(table, "density", body.density),
                         .density = 1.0});
  body.poisson = read_poisson(table);
  body.stated.push_back({.name = "poisson",
                         .value = body.poisson,
                         .sigma = read_sigma(table, "poisson", body.poisson),
                         .poisson = 1.0});
  body.elements = read_elements(table);
  const EndTable start = read_end(table, "start", body), end = read_end(table, "end", body);
  body.start = start.condition;
  body.start_support = start.support;
  body.end = end.condition;
  body.end_support = end.support;
  const CurveReport curve = report_curve(body, table.vectors3("points"), table.positive("length", 0.0));
  if (!curve.statement.empty())
    told.push_back({curve.statement, curve.error.digitised && curve.error.worst > fem::curve_tolerance});
  for (const std::string& warning : curve.warnings) warn(table.error("points", warning).what());
  if (table.node("material") != nullptr) body.material = read_material(table.table("material"), acts_in_time);
  table.finish();
  return body;
}

}  // namespace struna::apps
