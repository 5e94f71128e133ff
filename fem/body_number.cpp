#include "fem/body_number.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// The part of a support that a name like "start.rotation" tells.
struct SupportNumber {
  std::vector<End> ends;
  double ElasticSupport::*field;
};

const std::vector<std::pair<std::string, double ElasticSupport::*>>& support_fields() {
  static const std::vector<std::pair<std::string, double ElasticSupport::*>> fields = {
      {"rotation", &ElasticSupport::rotation},
      {"translation", &ElasticSupport::translation},
      {"mass", &ElasticSupport::mass}};
  return fields;
}

const std::vector<std::pair<std::string, std::vector<End>>>& support_ends() {
  static const std::vector<std::pair<std::string, std::vector<End>>> ends = {
      {"start", {End::start}}, {"end", {End::end}}, {"both", {End::start, End::end}}};
  return ends;
}

/// Nothing for a number that is no support's.
SupportNumber support_number(const std::string& name) {
  for (const auto& [end, ends] : support_ends()) {
    for (const auto& [field, member] : support_fields()) {
      if (name == end + "." + field) return {ends, member};
    }
  }
  return {{}, nullptr};
}

ElasticSupport& support_of(Body& body, End end) {
  return end == End::start ? body.start_support : body.end_support;
}

EndCondition& condition_of(Body& body, End end) {
  return end == End::start ? body.start : body.end;
}

/// Between truncation (its square) and rounding of the stiffness matrix, whose largest entries are some 1e8
/// times the first eigenvalue.
constexpr double relative_step = 2e-4;

}  // namespace

std::vector<std::string> fittable_numbers() {
  std::vector<std::string> names = {"torsion_constant"};
  for (const auto& [end, ends] : support_ends()) {
    for (const auto& [field, member] : support_fields()) names.push_back(end + "." + field);
  }
  return names;
}

BodyNumber fittable_number(const Body& body, const std::string& name) {
  BodyNumber number;
  number.name = name;
  if (name == "torsion_constant") {
    number.value = body.section.torsion_constant;
    number.section.torsion_constant = 1.0;
    return number;
  }
  const SupportNumber part = support_number(name);
  if (part.field == nullptr) {
    throw Error(fmt::format("only {} can be fitted, got \"{}\"", fmt::join(fittable_numbers(), ", "), name));
  }
  Body copy = body;
  for (const End end : part.ends) {
    if (condition_of(copy, end) == EndCondition::free && part.field != &ElasticSupport::mass) {
      throw Error(fmt::format("{} of body '{}' cannot be fitted: the {} is free, not a support", name,
                              body.name, end == End::start ? "start" : "end"));
    }
  }
  number.value = support_of(copy, part.ends.front()).*part.field;
  return number;
}

Body moved(Body body, const BodyNumber& number, double change) {
  body.section.area += number.section.area * change;
  body.section.second_moment += number.section.second_moment * change;
  body.section.torsion_constant += number.section.torsion_constant * change;
  body.density += number.density * change;
  body.poisson += number.poisson * change;
  if (number.length != 0.0) {
    const double length = body.centreline.length();
    body.centreline = body.centreline.scaled(1.0 + number.length * change / length);
  }
  const SupportNumber part = support_number(number.name);
  for (const End end : part.ends) {
    support_of(body, end).*part.field = number.value + change;
    if (part.field == &ElasticSupport::rotation) condition_of(body, end) = EndCondition::clamped;
  }
  return body;
}

Eigen::VectorXd log_eigenvalue_slopes(const Model& model, const Eigenmodes& modes, const BodyNumber& number) {
  if (!std::isfinite(number.value))
    throw Error(fmt::format("log_eigenvalue_slopes: {} must be finite", number.name));
  const Body& body = model.body;
  const double mass = body.density * body.section.area * body.centreline.length();
  // Only an added mass can be zero.
  const double step = relative_step * (number.value != 0.0 ? std::abs(number.value) : mass);
  const double below = number.value != 0.0 ? -step : 0.0;
  const int elements = static_cast<int>(model.arc_length.size()) - 1;
  const Model more = assemble(moved(body, number, step), elements);
  const Model less = assemble(moved(body, number, below), elements);
  const BandMatrix stiffness{(more.stiffness.lower - less.stiffness.lower) / (step - below)};
  const BandMatrix inertia{(more.mass.lower - less.mass.lower) / (step - below)};
  const auto along_modes = [&](const BandMatrix& matrix) {
    return Eigen::VectorXd(modes.shape.cwiseProduct(multiply(matrix, modes.shape)).colwise().sum());
  };
  return along_modes(stiffness).cwiseQuotient(modes.eigenvalue) - along_modes(inertia);
}

}  // namespace struna::fem
