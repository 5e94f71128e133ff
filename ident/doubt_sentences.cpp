#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "fem/error.hpp"
#include "ident/doubts.hpp"

namespace struna::ident {
namespace {

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

std::string open_sentence(const Doubt& doubt) {
  const std::string other = doubt.value > 0.0
                                ? fmt::format("other pairs, with a modulus of {:.3g} Pa, are", doubt.value)
                                : std::string("that they fit by chance is");
  return fmt::format(
      "which model modes were measured is open: {} of {} modes are paired, and {} {:.2g} times as probable: "
      "measure more modes, or tell where to look for the modulus (struna fit --modulus-range LO:HI, [fit] "
      "modulus_range of a study)",
      doubt.count, doubt.of, other, doubt.other);
}

std::string law_sentence(const Doubt& doubt) {
  const std::string& quantity = doubt.names.at(0);
  const std::string start =
      fmt::format("the {} law misses the {} of the modes by {:.2g} % rms, {:.2g} times the standard errors: ",
                  doubt.names.at(1), quantity, 100.0 * doubt.other, doubt.value);
  if (doubt.names.size() > 2) {
    return start + fmt::format(
                       "a {0} law meets them, but {1} modes are too few to choose it: name it "
                       "(--modulus-law {0}, [fit] modulus_law), or measure more modes",
                       doubt.names[2], doubt.count);
  }
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
    case DoubtKind::pairing_open:
      return open_sentence(doubt);
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

}  // namespace struna::ident
