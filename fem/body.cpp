#include "fem/body.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "fem/sizing.hpp"

namespace struna::fem {
namespace {

/// "body 'wire': FIELD must RULE, got VALUE".
void require(bool holds, const Body& body, const char* field, const char* rule, double value) {
  if (!holds) throw Error(fmt::format("body '{}': {} must {}, got {:g}", body.name, field, rule, value));
}

void require_positive(const Body& body, const char* field, double value) {
  require(value > 0.0 && std::isfinite(value), body, field, "be positive and finite", value);
}

void require_not_negative(const Body& body, const char* field, double value) {
  require(value >= 0.0 && std::isfinite(value), body, field, "not be negative", value);
}

void validate_support(const Body& body, const ElasticSupport& support, EndCondition condition,
                      const std::string& end) {
  const auto check = [&](const char* field, double value, bool gives, bool possible) {
    if (!gives && !std::isnan(value)) return;
    require_positive(body, (end + "." + field).c_str(), value);
    if (possible) return;
    throw Error(fmt::format("body '{}': {}.{} needs an end that is held so, but the {} is {}", body.name, end,
                            field, end, condition == EndCondition::free ? "free" : "pinned"));
  };
  check("translation", support.translation, support.gives_translation(), condition != EndCondition::free);
  check("rotation", support.rotation, support.gives_rotation(), condition == EndCondition::clamped);
  require_not_negative(body, (end + ".mass").c_str(), support.mass);
}

}  // namespace

Section solid_circle(double diameter) {
  if (!(diameter > 0.0 && std::isfinite(diameter))) {
    throw Error(fmt::format("solid_circle: diameter must be positive, got {:g} m", diameter));
  }
  const double area = std::numbers::pi / 4.0 * diameter * diameter;
  const double second_moment = area * diameter * diameter / 16.0;
  return {area, second_moment, 2.0 * second_moment};
}

Section ring(double outer_diameter, double inner_diameter) {
  if (!(inner_diameter > 0.0 && outer_diameter > inner_diameter && std::isfinite(outer_diameter))) {
    throw Error(fmt::format("ring: diameters must satisfy outer > inner > 0, got {:g} and {:g} m",
                            outer_diameter, inner_diameter));
  }
  const Section outer = solid_circle(outer_diameter);
  const Section inner = solid_circle(inner_diameter);
  return {outer.area - inner.area, outer.second_moment - inner.second_moment,
          outer.torsion_constant - inner.torsion_constant};
}

bool has_elastic_support(const Body& body) {
  return body.start_support.gives() || body.end_support.gives();
}

void validate_modulus(const Body& body) {
  validate(body.material.youngs_modulus, fmt::format("body '{}': youngs_modulus", body.name));
}

void validate(const Body& body) {
  if (body.name.empty()) throw Error("body: name must not be empty");
  require_positive(body, "area", body.section.area);
  require_positive(body, "second_moment", body.section.second_moment);
  require_positive(body, "torsion_constant", body.section.torsion_constant);
  require_positive(body, "density", body.density);
  require(body.poisson > -1.0 && body.poisson <= 0.5, body, "poisson", "lie in (-1, 0.5]", body.poisson);
  require(body.elements >= 0, body, "elements", "not be negative", body.elements);
  const FrequencyLaw& modulus = body.material.youngs_modulus;
  if (!modulus.parameters.empty() || !modulus.value.empty() || has_elastic_support(body))
    validate_modulus(body);
  validate_support(body, body.start_support, body.start, "start");
  validate_support(body, body.end_support, body.end, "end");
  validate(body.material.loss_factor, fmt::format("body '{}': loss_factor", body.name), true);
  require_not_negative(body, "rayleigh.alpha", body.material.rayleigh.alpha);
  require_not_negative(body, "rayleigh.beta", body.material.rayleigh.beta);
}

int recommended_elements(const Body& body, double highest_hz, double tolerance) {
  Body open = body;
  open.elements = 0;
  return choose_mesh(open, {0.0, highest_hz, tolerance}).elements;
}

}  // namespace struna::fem
