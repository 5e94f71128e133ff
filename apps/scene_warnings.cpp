#include "apps/scene_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/sizing.hpp"

namespace struna::apps {
namespace {

// Bending beams are shorter and longer than this, but seldom: silicone has 1e6 Pa, diamond 1.2e12 Pa, cork
// 120 kg/m^3, osmium 22590 kg/m^3.
constexpr double longest = 20.0;
constexpr double thickest = 0.5;
constexpr double softest = 1e6;
constexpr double hardest = 2e12;
constexpr double lightest = 50.0;
constexpr double heaviest = 25000.0;

/// Of a solid circle of the same area [m].
double diameter_of(const fem::Section& section) {
  return std::sqrt(4.0 * section.area / std::numbers::pi);
}

/// Lowest and highest modulus that the scene gives; {0, 0} when it gives none.
std::pair<double, double> modulus_range(const fem::Body& body) {
  const fem::FrequencyLaw& law = body.material.youngs_modulus;
  const std::vector<double>& given = law.value.empty() ? law.parameters : law.value;
  if (given.empty()) return {0.0, 0.0};
  const auto [lo, hi] = std::minmax_element(given.begin(), given.end());
  return {*lo, *hi};
}

void check_size(const fem::Body& body, std::vector<std::string>& warnings) {
  const double length = body.centreline.length();
  const double diameter = diameter_of(body.section);
  const std::string who = fmt::format("body '{}'", body.name);
  if (length > longest || diameter > thickest) {
    warnings.push_back(fmt::format(
        "{} is {:.4g} m long and {:.4g} m thick: lengths are in metres (1 mm is 0.001), areas in m^2", who,
        length, diameter));
  } else if (length < fem::least_slenderness * diameter) {
    warnings.push_back(fmt::format(
        "{} is {:.4g} m long and {:.4g} m thick, {:.2g} times its thickness: are both in metres? Below {:g} "
        "times, shear, which the model has not, counts",
        who, length, diameter, length / diameter, fem::least_slenderness));
  }
}

void check_material(const fem::Body& body, std::vector<std::string>& warnings) {
  const auto [softer, harder] = modulus_range(body);
  const auto tell_modulus = [&](double value, const char* than) {
    warnings.push_back(
        fmt::format("body '{}': youngs_modulus = {:.4g} Pa is {}: the unit is Pa (100 GPa is 100e9)",
                    body.name, value, than));
  };
  if (softer > 0.0 && softer < softest) tell_modulus(softer, "softer than silicone");
  if (harder > hardest) tell_modulus(harder, "harder than diamond");
  if (body.density < lightest || body.density > heaviest) {
    warnings.push_back(fmt::format("body '{}': density = {:.4g} kg/m^3 is {}: 7.65 g/cm^3 is 7650", body.name,
                                   body.density,
                                   body.density < lightest ? "lighter than cork" : "heavier than osmium"));
  }
}

}  // namespace

std::vector<std::string> scene_warnings(const fem::Scene& scene) {
  std::vector<std::string> warnings;
  for (const fem::Body& body : scene.bodies) {
    check_size(body, warnings);
    check_material(body, warnings);
  }
  return warnings;
}

}  // namespace struna::apps
