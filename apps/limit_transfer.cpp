#include "apps/limit_transfer.hpp"

#include "apps/limit_modes.hpp"
#include "apps/measured_transfer.hpp"
#include "apps/shaken_wire.hpp"
#include "fem/error.hpp"
#include "ident/mode_identification.hpp"

namespace struna::apps {
namespace {

constexpr Band shaken_band{10.0, 700.0};
constexpr Band analysed_band{95.0, 190.0};
constexpr double displacement_noise = 3e-4;
constexpr double segments = 7.5;  ///< as many as `struna frf` takes unless told otherwise

ident::Pole third_mode(const ShakenWire& wire) {
  return {wire.natural_frequencies_hz(analysed_band.hi_hz).at(2), wire.loss_factor};
}

/// As `struna identify` would judge one record: flags of the mode, and of what warns of its function.
LimitTrial trial_of(const ShakenWire& wire, const ident::Record& record, TransferSettings settings) {
  LimitTrial trial;
  try {
    settings.band = analysed_band;
    const MeasuredTransfer measured =
        examined(ident::estimate_transfer(record, "displacement", {"force_y"},
                                          {settings.method, settings.estimator, settings.welch, {}}),
                 settings);
    const ident::Pole truth = third_mode(wire);
    const auto modes = ident::identify_modes(measured.function).modes;
    const ident::Mode* const mode = mode_near(modes, truth);
    trial.refused = mode == nullptr;
    if (mode != nullptr) judge_mode(*mode, truth, trial);
    if (told(measured.warnings, "in the half-power band"))
      trial.flags += trial.flags.empty() ? "few_lines" : ";few_lines";
  } catch (const Error&) {
    trial.refused = true;
  }
  return trial;
}

LimitMap line_limits(const LimitRun& run, const ShakenWire& wire, ident::EstimateMethod method,
                     int usual_seeds, LimitMap map) {
  map.quantity = "natural frequency over the bandwidth or loss factor (relative): the worse of the two";
  map.axes = {run.axis("lines in the half-power band", {1, 1.5, 2, 3, 4, 6, 8, 10, 12, 16, 24}),
              run.axis("noise of the force [%]", {0.1, 0.3, 1, 3, 10})};
  const bool welch = method == ident::EstimateMethod::welch;
  const double bandwidth = ident::bandwidth_hz(third_mode(wire));
  for_each_place(map.axes, [&](const std::vector<double>& at) {
    for (const unsigned seed : run.draws(usual_seeds)) {
      TransferSettings settings;
      settings.method = method;
      if (welch) settings.welch.resolution_hz = bandwidth / at[0];
      const double duration = (welch ? segments : 1.0) * at[0] / bandwidth;
      const auto record = wire.record(duration, shaken_band.lo_hz, shaken_band.hi_hz,
                                      {displacement_noise, 0.01 * at[1]}, seed);
      LimitTrial trial = trial_of(wire, record, settings);
      trial.at = at;
      trial.seed = seed;
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
  return line_limits(run, {}, ident::EstimateMethod::welch, 10, std::move(map));
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
  return line_limits(run, wire, ident::EstimateMethod::local_rational, 10, std::move(map));
}

}  // namespace struna::apps
