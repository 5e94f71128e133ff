#include "apps/limit_transfer.hpp"

#include <cmath>
#include <functional>

#include "apps/limit_modes.hpp"
#include "apps/measured_transfer.hpp"
#include "apps/shaken_wire.hpp"
#include "fem/closed_forms.hpp"
#include "fem/error.hpp"
#include "ident/mode_identification.hpp"

namespace struna::apps {
namespace {

constexpr Band shaken_band{10.0, 700.0};
constexpr Band analysed_band{95.0, 190.0};
constexpr double displacement_noise = 3e-4;
constexpr double peak_tolerance = 0.05;  ///< stated in docs/limits.md
constexpr auto mode_quantity =
    "natural frequency over the bandwidth or loss factor (relative): the worse of the two";
constexpr double segments = 7.5;  ///< as many as `struna frf` takes unless told otherwise

ident::Pole third_mode(const ShakenWire& wire) {
  return {wire.natural_frequencies_hz(analysed_band.hi_hz).at(2), wire.loss_factor};
}

/// What a record of that wire gives.
struct Measurement {
  MeasuredTransfer transfer;
  ident::Pole truth;
};
using Judge = std::function<void(const Measurement&, LimitTrial&)>;

/// As `struna identify` would judge it: flags of the mode, and of what warns of its damping.
void judge_third_mode(const Measurement& measured, LimitTrial& trial) {
  const auto modes = ident::identify_modes(measured.transfer.function).modes;
  const ident::Mode* const mode = mode_near(modes, measured.truth);
  trial.refused = mode == nullptr;
  if (mode != nullptr) judge_mode(*mode, measured.truth, trial);
  if (told(measured.transfer.warnings, "damping may keep") ||
      told(measured.transfer.warnings, "damping is uncertain"))
    trial.flags += trial.flags.empty() ? "few_lines" : ";few_lines";
}

/// As a reader of the function would: |H| at the line nearest to resonance.
void judge_peak(const ShakenWire& wire, const Measurement& measured, LimitTrial& trial) {
  const ident::TransferFunction tf =
      ident::convert(measured.transfer.function, ident::FrfKind::dynamic_stiffness);
  long line = 0;
  (tf.frequency_hz.array() - measured.truth.natural_frequency_hz).abs().minCoeff(&line);
  const double truth =
      std::abs(fem::far_support_stiffness(wire.beam, wire.loss_factor, tf.frequency_hz[line]));
  const auto& output = tf.outputs.front();
  trial.error = std::abs(std::abs(output.value[line]) / truth - 1.0);
  trial.sigma = output.sigma[line] / truth;
  trial.tolerance = peak_tolerance;
  if (told(measured.transfer.warnings, "leakage lowers")) trial.flags = "lowered";
}

LimitMap line_limits(const LimitRun& run, const ShakenWire& wire, ident::EstimateMethod method,
                     const Judge& judge, LimitMap map) {
  map.axes = {run.axis("lines in the half-power band", {1, 1.5, 2, 3, 4, 6, 8, 10, 12, 16, 24}),
              run.axis("noise of the force [%]", {0.1, 0.3, 1, 3, 10})};
  const bool welch = method == ident::EstimateMethod::welch;
  const ident::Pole truth = third_mode(wire);
  for_each_place(map.axes, [&](const std::vector<double>& at) {
    for (const unsigned seed : run.draws(10)) {
      TransferSettings settings;
      settings.method = method;
      settings.band = analysed_band;
      if (welch) settings.welch.resolution_hz = ident::bandwidth_hz(truth) / at[0];
      const double duration = (welch ? segments : 1.0) * at[0] / ident::bandwidth_hz(truth);
      const auto record = wire.record(duration, shaken_band.lo_hz, shaken_band.hi_hz,
                                      {displacement_noise, 0.01 * at[1]}, seed);
      LimitTrial trial;
      trial.at = at;
      trial.seed = seed;
      try {
        judge({examined(ident::estimate_transfer(record, "displacement", {"force_y"},
                                                 {settings.method, settings.estimator, settings.welch, {}}),
                        settings),
               truth},
              trial);
      } catch (const Error&) {
        trial.refused = true;
      }
      map.trials.push_back(std::move(trial));
    }
  });
  return map;
}

}  // namespace

LimitMap leakage_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "leakage";
  map.title = "Hann window: lines in the half-power band";
  map.fails = "the window widens a resonance, by more than can be taken out of its loss factor";
  map.sign = "what leakage makes of the lines in the half-power band";
  map.then = "adds to the standard error, and below three lines warns and flags the mode coarse";
  map.quantity = mode_quantity;
  return line_limits(run, {}, ident::EstimateMethod::welch, judge_third_mode, std::move(map));
}

LimitMap leakage_peak_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "leakage_peak";
  map.title = "Hann window: the peak of a function";
  map.quantity = "|H| at the line nearest to resonance (relative)";
  map.fails = "the window averages a resonance over its lines and lowers its peak";
  map.sign = "the half-power band that is seen, against the lines";
  map.then = "warns, and names the resonances and by how much";
  const ShakenWire wire;
  return line_limits(
      run, wire, ident::EstimateMethod::welch,
      [&](const Measurement& measured, LimitTrial& trial) { judge_peak(wire, measured, trial); },
      std::move(map));
}

LimitMap local_model_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "local_model";
  map.title = "Local rational model: lines in the half-power band";
  map.fails = "a resonance narrower than the lines is hard to tell from noise";
  map.sign = "a half-power band between two lines, and the standard errors";
  map.then = "warns, flags the mode noisy or coarse, or does not find it";
  ShakenWire wire;
  wire.loss_factor = 0.002;  // records of 4 to 91 s
  map.quantity = mode_quantity;
  return line_limits(run, wire, ident::EstimateMethod::local_rational, judge_third_mode, std::move(map));
}

}  // namespace struna::apps
