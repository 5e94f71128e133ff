#include "ident/fixture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;

/// Power of i omega by which an apparent mass is multiplied to give the form.
int order_of(const TransferFunction::Output& output, const char* what) {
  switch (output.kind) {
    case FrfKind::apparent_mass:
      return 0;
    case FrfKind::impedance:
      return 1;
    case FrfKind::dynamic_stiffness:
      return 2;
    default:
      throw Error(fmt::format("{} can be taken out of a force over motion only, but {} is in {}", what,
                              output.name, output.unit));
  }
}

Eigen::ArrayXcd i_omega(const Eigen::VectorXd& frequency_hz) {
  return Complex(0.0, 2.0 * std::numbers::pi) * frequency_hz.array();
}

}  // namespace

TransferFunction without_mass(TransferFunction function, const std::map<std::string, double>& mass) {
  for (const auto& [name, kilogram] : mass) {
    if (!(kilogram >= 0.0 && std::isfinite(kilogram)))
      throw Error(
          fmt::format("clamp mass of {}: must be finite and not negative, got {} kg", name, kilogram));
    const auto output = std::find_if(function.outputs.begin(), function.outputs.end(),
                                     [&](const auto& other) { return other.name == name; });
    if (output == function.outputs.end())
      throw Error(fmt::format("clamp mass of {}: there is no such output", name));
    const int order = order_of(*output, "a clamp mass");
    output->value -= (kilogram * i_omega(function.frequency_hz).pow(order)).matrix();
  }
  return function;
}

TransferFunction without_fixture(TransferFunction function, const TransferFunction& empty) {
  const long lines = empty.lines();
  if (lines > 1 && empty.frequency_hz[0] == 0.0)  // says nothing of a mass
    return without_fixture(std::move(function),
                           restrict_band(empty, empty.frequency_hz[1], empty.frequency_hz[lines - 1]));
  const double lo = function.frequency_hz[0], hi = function.frequency_hz[function.lines() - 1];
  if (lines < 2 || empty.frequency_hz[0] > lo || empty.frequency_hz[lines - 1] < hi)
    throw Error(fmt::format(
        "the empty run has lines from {:.6g} to {:.6g} Hz, the function from {:.6g} to {:.6g} Hz: measure it "
        "over the "
        "same band, or narrow the band",
        lines > 0 ? empty.frequency_hz[0] : 0.0, lines > 0 ? empty.frequency_hz[lines - 1] : 0.0, lo, hi));
  bool found = false;
  for (TransferFunction::Output& output : function.outputs) {
    const auto fixture = std::find_if(empty.outputs.begin(), empty.outputs.end(),
                                      [&](const auto& other) { return other.name == output.name; });
    if (fixture == empty.outputs.end()) continue;
    found = true;
    const Eigen::ArrayXcd form = i_omega(function.frequency_hz).pow(order_of(output, "a fixture"));
    // As an apparent mass, the smoothest of its forms.
    const Eigen::ArrayXcd lower = i_omega(empty.frequency_hz).pow(-order_of(*fixture, "a fixture"));
    const Eigen::ArrayXcd mass = fixture->value.array() * lower;
    const bool noisy = output.sigma.size() > 0 && fixture->sigma.size() > 0;
    const Eigen::ArrayXd sigma =
        noisy ? Eigen::ArrayXd(fixture->sigma.array() * lower.abs()) : Eigen::ArrayXd();
    for (long i = 0, below = 0; i < function.lines(); ++i) {
      const double f = function.frequency_hz[i];
      while (below + 2 < lines && empty.frequency_hz[below + 1] < f) ++below;
      const double share =
          (f - empty.frequency_hz[below]) / (empty.frequency_hz[below + 1] - empty.frequency_hz[below]);
      const auto between = [&](const auto& column) {
        return (1.0 - share) * column[below] + share * column[below + 1];
      };
      output.value[i] -= form[i] * between(mass);
      if (noisy) output.sigma[i] = std::hypot(output.sigma[i], std::abs(form[i]) * between(sigma));
    }
    // Coherence told of the force with the fixture in it.
    output.coherence.resize(0);
  }
  if (!found)
    throw Error(fmt::format("the empty run has none of the outputs (its first is {})",
                            empty.outputs.empty() ? "missing" : empty.outputs.front().name));
  return function;
}

}  // namespace struna::ident
