#include "apps/limit_damping.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>

#include "fem/closed_forms.hpp"
#include "fem/simulation.hpp"

namespace struna::apps {
namespace {

constexpr double force_tolerance = 0.05;  ///< stated in docs/limits.md
constexpr double diameter = 0.0032, density = 7650.0, modulus = 120e9;
constexpr double hi_hz = 1000.0, at_hz = 300.0;

fem::FrequencyLaw power_law(double value, double exponent) {
  return {fem::FrequencyLaw::Kind::power, {value, exponent, at_hz}, {}, {}, 0.0, 0.0};
}

/// A wire and the band in which it is shaken.
struct Draw {
  double length, lo_hz;
  fem::Material material;
};

Draw drawn(const std::vector<double>& at, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform;
  Draw draw;
  draw.length = 0.25 + 0.1 * uniform(engine);
  draw.lo_hz = 15.0 + 15.0 * uniform(engine);
  draw.material.youngs_modulus = power_law(modulus, at[1]);
  draw.material.loss_factor = power_law(0.01 * at[0], at[2]);
  draw.material.damping = fem::Damping::structural;
  return draw;
}

/// The wire at a frequency.
fem::ClampedBeam beam_at(const Draw& draw, double f_hz) {
  const fem::Section section = fem::solid_circle(diameter);
  return {draw.length, draw.material.youngs_modulus.at(f_hz) * section.second_moment, density * section.area};
}

/// Slowest decay of the modes that the motion reaches [1/s], eta w/2.
double slowest_decay(const Draw& draw) {
  double slowest = std::numeric_limits<double>::infinity();
  for (int mode = 1;; ++mode) {
    const double f = fem::natural_frequency_hz(beam_at(draw, at_hz), mode);
    slowest = std::min(slowest, std::numbers::pi * f * draw.material.loss_factor.at(f));
    if (f > hi_hz) return slowest;
  }
}

fem::Scene shaken_wire(const Draw& draw, unsigned seed) {
  fem::Body wire{
      "wire", fem::straight_line({0, 0, 0}, {draw.length, 0, 0}), fem::solid_circle(diameter), density, 0.3,
      {}};
  wire.material = draw.material;
  wire.elements = 32;
  fem::Scene scene;
  scene.bodies = {wire};
  scene.drive = fem::SceneDrive{fem::Support{"wire", fem::End::start}, Eigen::Vector3d::UnitY(), {}};
  scene.measurement = fem::SceneMeasurement{fem::Support{"wire", fem::End::end},
                                            fem::MotionQuantity::displacement,
                                            {"force_y"},
                                            {Eigen::Vector3d::UnitY()}};
  fem::Simulation simulation;
  constexpr double settled = 6.0;  // exp(-6) of the start is left: 0.25 %
  simulation.sample_rate = 4000.0;
  // Whole samples in a period, which is half the duration.
  const double period = std::ceil(std::max(1.0, settled / slowest_decay(draw)) * simulation.sample_rate) /
                        simulation.sample_rate;
  simulation.duration = 2.0 * period;
  simulation.excitation.kind = fem::Excitation::Kind::multisine;
  // Half a line below the first one, so that each line stands for as much of the band.
  simulation.excitation.band_lo_hz = (std::round(draw.lo_hz * period) - 0.5) / period;
  simulation.excitation.band_hi_hz = hi_hz;
  simulation.excitation.rms_acceleration = 1.0;
  simulation.excitation.seed = seed;
  scene.simulation = simulation;
  return scene;
}

std::vector<std::complex<double>> spectrum_of(const Eigen::VectorXd& signal) {
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, std::vector<double>(signal.begin(), signal.end()));
  return spectrum;
}

/// Relative rms of the force over the last period, against the harmonic response to that period's motion.
double distance_from_harmonic(const fem::TimeResponse& response, const Draw& draw, double period) {
  const auto samples = std::lround(period / response.sample_interval);
  const auto motion = spectrum_of(response.motion.tail(samples));
  const auto force = spectrum_of(response.output.col(0).tail(samples));
  double off = 0.0, all = 0.0;
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const double f = static_cast<double>(k) / period;
    if (f < draw.lo_hz - 1.0 / period || f > hi_hz + 1.0 / period) continue;
    const auto expected =
        motion[k] * fem::far_support_stiffness(beam_at(draw, f), draw.material.loss_factor.at(f), f);
    off += std::norm(force[k] - expected);
    all += std::norm(expected);
  }
  return std::sqrt(off / all);
}

}  // namespace

LimitMap damping_in_time_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "damping_in_time";
  map.title = "Structural damping in time: loss factor, E(f), eta(f)";
  map.quantity = "force at the far support (rms over rms)";
  map.fails =
      "no causal law has this loss factor and this rise of the modulus at once, and the wire answers in time "
      "as another material would";
  map.sign = "the law's own response, compared with the harmonic one before the run";
  map.then = "warns and tells the distance";
  map.axes = {run.axis("loss factor at 300 Hz [%]", {1, 2, 5, 10, 20, 40}),
              run.axis("slope of ln E over ln f", {0, 0.01, 0.03, 0.1, 0.2}),
              run.axis("slope of ln eta over ln f", {-1, -0.5, 0, 0.5})};
  for_each_place(map.axes, [&](const std::vector<double>& at) {
    for (const unsigned seed : run.draws(1)) {
      const Draw draw = drawn(at, seed);
      const fem::Scene scene = shaken_wire(draw, seed);
      const fem::TimeResponse response = fem::simulate(scene, fem::scene_motion(scene));
      LimitTrial trial;
      trial.at = at;
      trial.seed = seed;
      trial.error = distance_from_harmonic(response, draw, fem::multisine_period(scene.simulation->duration));
      trial.tolerance = force_tolerance;
      if (told(response.report.warnings, "no causal material")) trial.flags = "causal";
      map.trials.push_back(std::move(trial));
    }
  });
  return map;
}

}  // namespace struna::apps
