#include "fem/sizing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

constexpr int least_elements = 6;
constexpr int least_contact_elements = 8;
constexpr int most_elements = 1000;  ///< as many as a scene may ask for
constexpr int band_stations = 40;
/// The element is exact in statics whatever it turns; its inertia is integrated to the eighth power of the
/// turn.
constexpr double largest_turn = std::numbers::pi / 4.0;
/// Possible contact points are the nodes: close enough to probe the curve.
constexpr double largest_contact_turn = std::numbers::pi / 18.0;
/// Of a curved body's stretch error in its outputs, a priori; 0.02 to 0.6 were measured, so it is checked
/// afterwards.
constexpr double stretch_share = 0.1;
constexpr double undamped_loss_factor = 1e-3;
/// Of the first natural frequency, times n^4: half of 1e-9 of its square with 100 elements (beam_element.md).
constexpr double rounding = 5e-18;

void require(bool holds, const Body& body, const char* field, const char* rule, double value) {
  if (!holds) throw Error(fmt::format("body '{}': {} must {}, got {:g}", body.name, field, rule, value));
}

void validate(const Body& body, const MeshRequest& request) {
  validate(body);
  validate_modulus(body);
  require(request.hi_hz > 0.0 && std::isfinite(request.hi_hz), body, "highest frequency",
          "be positive and finite", request.hi_hz);
  require(request.lo_hz >= 0.0 && request.lo_hz <= request.hi_hz, body, "lowest frequency",
          "lie between 0 and the highest", request.lo_hz);
  require(request.tolerance > 0.0 && request.tolerance < 1.0, body, "tolerance", "lie between 0 and 1",
          request.tolerance);
}

double omega(double f_hz) {
  return 2.0 * std::numbers::pi * f_hz;
}

/// b [1/m] of a bending wave: b^4 = rho A w^2/(E I).
double bending_wavenumber(const Body& body, double f_hz) {
  const double stiffness = body.material.youngs_modulus.at(f_hz) * body.section.second_moment;
  return std::pow(body.density * body.section.area * omega(f_hz) * omega(f_hz) / stiffness, 0.25);
}

/// k [1/m] of a stretch wave.
double stretch_wavenumber(const Body& body, double f_hz) {
  return omega(f_hz) * std::sqrt(body.density / body.material.youngs_modulus.at(f_hz));
}

/// k [1/m] of a torsion wave: G J against the rotary inertia of the polar moment 2 I.
double torsion_wavenumber(const Body& body, double f_hz) {
  return stretch_wavenumber(body, f_hz) *
         std::sqrt(2.0 * (1.0 + body.poisson) * 2.0 * body.section.second_moment /
                   body.section.torsion_constant);
}

/// k L of the highest mode of a bar below `waves` = k L: a multiple of pi, or odd ones of pi/2 where one end
/// alone is held. 0: none.
double highest_bar_mode(double waves, bool start_held, bool end_held) {
  const double shift = start_held == end_held ? 0.0 : 0.5;
  const double mode = std::floor(waves / std::numbers::pi + shift) - shift;
  return mode > 0.0 ? mode * std::numbers::pi : 0.0;
}

/// k L of the stretch or torsion waves that the natural frequencies up to f_hz hold.
double bar_waves_in_modes(const Body& body, double f_hz) {
  const double length = body.centreline.length();
  const double stretch = stretch_wavenumber(body, f_hz) * length;
  const double torsion = torsion_wavenumber(body, f_hz) * length;
  if (!body.centreline.is_straight()) {
    const double waves = std::max(stretch, torsion);
    return waves > 0.9 * std::numbers::pi ? waves : 0.0;
  }
  const auto held = [](EndCondition end) { return end != EndCondition::free; };
  const auto clamped = [](EndCondition end) { return end == EndCondition::clamped; };
  return std::max(highest_bar_mode(stretch, held(body.start), held(body.end)),
                  highest_bar_mode(torsion, clamped(body.start), clamped(body.end)));
}

bool reaches_stretch_waves(const Body& body, double f_hz) {
  return stretch_wavenumber(body, f_hz) * body.centreline.length() > 0.9 * std::numbers::pi;
}

/// |d ln H/d ln f| at most: 2/eta at a resonance; 2 of a prescribed motion's inertia; the phase of a wave
/// that runs the length, d(b L)/d ln f.
double steepness(const Body& body, Damping damping, double f_hz) {
  const double eta = acting_loss_factor(body.material, damping, f_hz);
  const double waves = bending_wavenumber(body, f_hz) * body.centreline.length();
  return 2.0 / (eta > 0.0 ? eta : undamped_loss_factor) + 2.0 + 0.5 * waves;
}

double largest_curvature(const Centreline& centreline) {
  constexpr int stations = 200;
  double largest = 0.0;
  for (int i = 0; !centreline.is_straight() && i <= stations; ++i) {
    largest = std::max(largest, centreline.at(centreline.length() * i / stations).curvature.norm());
  }
  return largest;
}

/// Errors of a mesh of n elements at one frequency are bending/n^4 + stretch/n^2 + rounding n^4.
struct ErrorTerms {
  double bending = 0.0, stretch = 0.0, rounding = 0.0;
  MeshError at(int elements) const {
    const double n2 = static_cast<double>(elements) * elements;
    return {bending / (n2 * n2), stretch / n2, rounding * n2 * n2};
  }
};

ErrorTerms terms_at(const Body& body, const MeshRequest& request, double f_hz) {
  const double length = body.centreline.length();
  const double bending = std::pow(bending_wavenumber(body, f_hz) * length, 4) / 1440.0;
  double bar = 0.0;
  if (request.target == SizingTarget::natural_frequencies) {
    bar = bar_waves_in_modes(body, f_hz);
    return {bending, bar * bar / 24.0, rounding};
  }
  const bool straight = body.centreline.is_straight();
  if (straight ? request.along_axis : reaches_stretch_waves(body, f_hz)) {
    bar = stretch_wavenumber(body, f_hz) * length;
  }
  const double steep = steepness(body, request.damping, f_hz);
  const double eigenvalue = omega(f_hz) * omega(f_hz) / body.material.youngs_modulus.at(f_hz);
  return {steep * bending, steep * (straight ? 1.0 : stretch_share) * bar * bar / 24.0,
          steep * rounding * std::min(1.0, clamped_eigenvalue(body) / eigenvalue)};
}

/// Over the band; a single one, the highest, tells of natural frequencies.
std::vector<ErrorTerms> error_terms(const Body& body, const MeshRequest& request) {
  if (request.target == SizingTarget::natural_frequencies) return {terms_at(body, request, request.hi_hz)};
  const double from = std::max(request.lo_hz, 1e-3 * request.hi_hz);
  std::vector<ErrorTerms> terms;
  for (int i = 0; i <= band_stations; ++i) {
    const double share = static_cast<double>(i) / band_stations;
    terms.push_back(terms_at(body, request, from * std::pow(request.hi_hz / from, share)));
  }
  return terms;
}

MeshError worst(const std::vector<ErrorTerms>& terms, int elements) {
  MeshError worst;
  for (const ErrorTerms& term : terms) {
    const MeshError error = term.at(elements);
    if (error.total() > worst.total()) worst = error;
  }
  return worst;
}

}  // namespace

double acting_loss_factor(const Material& material, Damping damping, double f_hz) {
  return damping == Damping::structural ? material.loss_factor.at(f_hz)
                                        : 2.0 * rayleigh_damping_ratio(material.rayleigh, f_hz);
}

MeshError estimate_mesh_error(const Body& body, const MeshRequest& request, int elements) {
  validate(body, request);
  require(elements >= 1, body, "elements", "be at least 1", elements);
  return worst(error_terms(body, request), elements);
}

MeshChoice choose_mesh(const Body& body, const MeshRequest& request) {
  validate(body, request);
  const std::vector<ErrorTerms> terms = error_terms(body, request);
  MeshChoice choice;
  choice.tolerance = request.tolerance;
  if (body.elements > 0) {
    choice.elements = body.elements;
    choice.error = worst(terms, choice.elements);
    return choice;
  }
  const double turn = body.centreline.length() * largest_curvature(body.centreline);
  const double parts = std::ceil(turn / (request.contact ? largest_contact_turn : largest_turn));
  const int by_turn = static_cast<int>(std::min<double>(parts, most_elements));
  const int least = request.contact ? least_contact_elements : least_elements;
  const int first = std::max(by_turn, least);
  choice.elements = first;
  choice.error = worst(terms, first);
  choice.reason = by_turn > least ? MeshReason::turn : MeshReason::least;
  for (int n = first + 1; n <= most_elements && !choice.within(); ++n) {
    const MeshError error = worst(terms, n);
    if (error.total() >= choice.error.total()) {  // rounding grows from here on
      choice.reason = MeshReason::limit;
      return choice;
    }
    choice.elements = n;
    choice.error = error;
    choice.reason = error.bending > error.stretch ? MeshReason::bending : MeshReason::stretch;
  }
  if (!choice.within()) choice.reason = MeshReason::limit;
  require(choice.error.total() < 1.0, body, "elements for the band up to that frequency", "stay below 1000",
          request.hi_hz);
  return choice;
}

bool is_sure(const Body& body, const MeshRequest& request) {
  return body.centreline.is_straight() || !reaches_stretch_waves(body, request.hi_hz);
}

double error_from_difference(double difference, bool sure) {
  return difference * (sure ? 16.0 / 15.0 : 4.0 / 3.0);
}

int refined_elements(int elements, double error, double tolerance, bool sure) {
  const double factor = std::pow(1.1 * error / tolerance, sure ? 0.25 : 0.4);
  return std::min(most_elements, static_cast<int>(std::ceil(elements * std::clamp(factor, 1.0, 4.0))));
}

double narrowest_bandwidth_hz(const Body& body, Damping damping, double lo_hz, double hi_hz) {
  // 3 % in frequency is enough to tell a bandwidth.
  Body coarse = body;
  coarse.elements = 0;
  const int elements = choose_mesh(coarse, {lo_hz, hi_hz, 0.03, SizingTarget::natural_frequencies}).elements;
  const Eigen::VectorXd f =
      natural_frequencies_hz(body, solve_eigenmodes(assemble(body, elements)).eigenvalue);
  double narrowest = 0.0;
  for (const double f_hz : f) {
    if (f_hz <= 0.0 || f_hz < lo_hz || f_hz > hi_hz) continue;
    const double width = acting_loss_factor(body.material, damping, f_hz) * f_hz;
    if (narrowest == 0.0 || width < narrowest) narrowest = width;
  }
  return narrowest;
}

double beam_theory_error(const Body& body, double f_hz) {
  const double nu = body.poisson;
  const double shear = (7.0 + 6.0 * nu) / 3.0;  // E/(kappa G)
  const double wavenumber = bending_wavenumber(body, f_hz);
  return 0.5 * wavenumber * wavenumber * body.section.second_moment / body.section.area * (1.0 + shear);
}

}  // namespace struna::fem
