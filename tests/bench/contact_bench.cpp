// Time stepping with contact: error against time.
//   wb1      the benchmark WB-1 (tests/fem/wb1.hpp), 0.5 s; error: largest over 500 instants, of the gap
//   filter   the mechanical filter (straight wire of 25 elements, band of 16 around it, gap 5e-5 m, approach
//   law,
//            100 m/s^2) over 20 ms around 200 Hz, before trajectories part; error: of the largest
//            displacement
//   cost     time per contact step against modes and closed contacts
// Rows: study,method,knob,value,error,time [s]. One thread, processor time.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "fem/simulation_plan.hpp"
#include "tests/fem/wb1.hpp"

namespace {

using namespace struna::fem;

double seconds_of(const std::function<void()>& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

struct Run {
  std::vector<double> path;  ///< of the watched point
  double seconds = 0.0;
};

/// Largest distance of two paths over the largest of the reference, or over `scale`.
double distance(const Run& run, const Run& reference, double scale = 0.0) {
  double worst = 0.0;
  double largest = scale;
  for (std::size_t i = 0; i < run.path.size(); ++i) {
    worst = std::max(worst, std::abs(run.path[i] - reference.path[i]));
    if (scale == 0.0) largest = std::max(largest, std::abs(reference.path[i]));
  }
  return worst / largest;
}

void row(const std::string& study, const std::string& method, const std::string& knob, double value,
         double error, double seconds) {
  fmt::print("{},{},{},{:g},{:.3g},{:.4g}\n", study, method, knob, value, error, seconds);
}

template <class Stepper>
Run follow(Stepper stepper, int point, int component, double duration, int samples) {
  Run run;
  run.seconds = seconds_of([&] {
    for (int i = 1; i <= samples; ++i) {
      stepper.advance(duration * i / samples);
      run.path.push_back(stepper.offset(point)[component]);
    }
  });
  return run;
}

ModalSteppingOptions fixed_step(double step, int substeps) {
  ModalSteppingOptions options;
  options.step = step;
  options.contact_substeps = substeps;
  return options;
}

ModalSteppingOptions to_tolerance(double tolerance) {
  ModalSteppingOptions options;
  options.tolerance = tolerance;
  return options;
}

void bench_wb1() {
  const testing::Wb1Modal modal;
  const testing::Wb1Nodal nodal;
  const auto modal_run = [&](const ModalSteppingOptions& o) {
    return follow(modal.stepper(o), 0, 0, 0.5, 500);
  };
  const Run reference = modal_run(fixed_step(1e-6, 5));
  for (const double step : {2e-4, 1e-4, 5e-5, 2e-5}) {
    const Run run = modal_run(fixed_step(step, 20));
    row("wb1", "modal", "step (cut 20)", step, distance(run, reference, testing::wb1_gap), run.seconds);
  }
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const Run run = modal_run(to_tolerance(tolerance));
    row("wb1", "modal", "tolerance", tolerance, distance(run, reference, testing::wb1_gap), run.seconds);
  }
  for (const double step : {1e-4, 5e-5, 2e-5, 1e-5}) {
    NewmarkOptions options;
    options.step = step;
    const Run run = follow(nodal.stepper(options), 0, 0, 0.5, 500);
    row("wb1", "newmark", "step (cut 5)", step, distance(run, reference, testing::wb1_gap), run.seconds);
  }
  for (const int modes : {10, 20, 30, 40, 54}) {
    ModalSteppingOptions options = to_tolerance(1e-4);
    options.highest_mode_hz = 24.4 * (modes + 1) * (modes + 1) / 2.25 * 1.2;
    ModalStepper stepper = modal.stepper(options);
    const int stepped = stepper.report().modes;
    const Run run = follow(std::move(stepper), 0, 0, 0.5, 500);
    row("wb1", "modal, others static", "modes", stepped, distance(run, reference, testing::wb1_gap),
        run.seconds);
  }
}

Scene filter_scene() {
  Body wire{"wire",
            straight_line({0, 0, 0}, {0.501, 0, 0}),
            {8.042477e-6, 3.1083e-12, 2 * 3.1083e-12},
            7650.0,
            0.3,
            {},
            25,
            EndCondition::clamped,
            EndCondition::clamped};
  wire.material.youngs_modulus = constant_law(100e9);
  wire.material.rayleigh = {43.1, 2e-6};
  wire.material.damping = Damping::viscous;
  Body band = wire;
  band.name = "band";
  band.centreline = straight_line({0.12, 0, 0}, {0.441, 0, 0});
  band.section = {6.126106e-5, 3.9245e-10, 2 * 3.9245e-10};
  band.density = 4535.0;
  band.elements = 16;
  band.material.youngs_modulus = constant_law(30e9);
  Scene scene;
  scene.bodies = {wire, band};
  scene.drive = SceneDrive{Support{"wire", End::start}, Eigen::Vector3d::UnitY(), {}};
  scene.measurement = SceneMeasurement{
      Support{"wire", End::end}, MotionQuantity::displacement, {"force_y"}, {Eigen::Vector3d::UnitY()}};
  scene.contacts = {{"wire", "band", 5e-5, 1e5, 100.0, ContactLaw::approach}};
  scene.simulation = Simulation{};
  scene.simulation->duration = 10.0;
  return scene;
}

MotionSample filter_motion(double t) {
  const double omega = 2.0 * std::numbers::pi * 200.0;
  const double a = 100.0;
  return {-a / (omega * omega) * std::sin(omega * t), -a / omega * std::cos(omega * t),
          a * std::sin(omega * t)};
}

void bench_filter() {
  const Scene scene = filter_scene();
  SimulationPlan plan = plan_simulation(scene, 1000.0);
  std::vector<ModalBody> modal;
  std::vector<NodalBody> nodal;
  for (const PlannedBody& body : plan.bodies) {
    modal.push_back(modal_body(body.model, body.modes, body.coordinates, body.drive, 1000.0));
    const Material& material = body.model.body.material;
    nodal.push_back(nodal_body(body.model, material.youngs_modulus.at(1.0), material.rayleigh,
                               body.drive.moved, body.drive.direction));
  }
  Scene newmark_scene = scene;
  newmark_scene.simulation->method = IntegrationMethod::newmark;
  const std::vector<ContactPoint> nodal_points = plan_simulation(newmark_scene, 1000.0).points;
  const int middle = static_cast<int>(plan.points.size()) / 2;
  constexpr double duration = 0.02;
  constexpr int samples = 200;
  const auto modal_run = [&](const ModalSteppingOptions& options) {
    return follow(ModalStepper(modal, plan.points, filter_motion, options), middle, 0, duration, samples);
  };
  const Run reference = modal_run(fixed_step(1e-6, 10));
  row("filter", "modal", "step (cut 10)", 2e-6, distance(modal_run(fixed_step(2e-6, 10)), reference), 0.0);
  for (const double step : {5e-5, 2e-5, 1e-5, 5e-6}) {
    const Run run = modal_run(fixed_step(step, 10));
    row("filter", "modal", "step (cut 10)", step, distance(run, reference), run.seconds);
  }
  std::vector<std::pair<double, double>> reached;  // error and time of the modal method
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const Run run = modal_run(to_tolerance(tolerance));
    reached.emplace_back(distance(run, reference), run.seconds);
    row("filter", "modal", "tolerance", tolerance, reached.back().first, run.seconds);
  }
  for (const double step : {2e-5, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7}) {
    NewmarkOptions options;
    options.step = step;
    NewmarkStepper stepper(nodal, nodal_points, filter_motion, options);
    stepper.settle();
    const Run run = follow(std::move(stepper), middle, 0, duration, samples);
    const double error = distance(run, reference);
    row("filter", "newmark", "step (cut 5)", step, error, run.seconds);
    // Against the cheapest modal run that is no less accurate.
    double cheapest = 0.0;
    for (const auto& [other, seconds] : reached) {
      if (other <= error && (cheapest == 0.0 || seconds < cheapest)) cheapest = seconds;
    }
    if (cheapest > 0.0)
      row("filter", "newmark over modal", "ratio of times", step, error, run.seconds / cheapest);
  }
}

/// A string of `modes` modes resting on `contacts` stops that stay closed, in gentle motion.
double bench_cost(int modes, int contacts) {
  ModalBody body;
  body.poles.modes = modes;
  body.poles.pole.resize(modes);
  body.poles.residue.resize(modes);
  body.poles.mode.resize(modes);
  body.load = Eigen::MatrixX3d::Zero(modes, 3);
  body.constant_load = Eigen::VectorXd::Zero(modes);
  for (int m = 0; m < modes; ++m) {
    const double omega = 300.0 * (m + 1);
    body.poles.pole[m] = {-0.01 * omega, omega};
    body.poles.residue[m] = {0.0, -1.0 / omega};
    body.poles.mode[m] = m;
    body.load(m, 2) = 0.01;
    body.constant_load[m] = m % 2 == 0 ? 1e3 / (m + 1) : 0.0;
  }
  std::vector<ContactPoint> points(static_cast<std::size_t>(contacts));
  for (int i = 0; i < contacts; ++i) {
    ContactPoint& point = points[static_cast<std::size_t>(i)];
    point.law = {ContactLaw::approach, 1e4, 1.0};
    point.gap = 1e-6;
    point.shape = StopShape::wall;
    point.inside = Eigen::MatrixX2d::Zero(modes, 2);
    for (int m = 0; m < modes; ++m) {
      point.inside(m, 0) = std::sin(std::numbers::pi * (m + 1) * (i + 1) / (contacts + 1.0));
    }
  }
  ModalStepper stepper({body}, points, filter_motion, fixed_step(1e-5, 1));
  stepper.settle();
  const double seconds = seconds_of([&] { stepper.advance(20.0 / (modes + 40.0)); });
  const StepReport& report = stepper.report();
  const double steps = static_cast<double>(report.contact_steps + report.free_steps + report.rejected_steps);
  row("cost", fmt::format("modal, {} contacts", contacts), "modes", modes, 0.0, seconds / steps);
  return seconds / steps;
}

/// Exponent p of y ~ x^p, by least squares of the logarithms.
double exponent(const std::vector<double>& x, const std::vector<double>& y) {
  const double n = static_cast<double>(x.size());
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double u = std::log(x[i]);
    const double v = std::log(y[i]);
    sx += u;
    sy += v;
    sxx += u * u;
    sxy += u * v;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// Cost of a step against modes x closed contacts: no more than linear in the product.
void bench_costs() {
  const std::vector<int> all_modes = {20, 80, 320, 1280};
  const std::vector<int> all_contacts = {1, 2, 4, 8, 16};
  std::map<std::pair<int, int>, double> cost;
  for (const int contacts : all_contacts) {
    for (const int modes : all_modes) cost[{modes, contacts}] = bench_cost(modes, contacts);
  }
  std::vector<double> products, times;
  for (const auto& [key, seconds] : cost) {
    products.push_back(key.first * key.second);
    times.push_back(seconds);
  }
  row("cost", "exponent of modes x contacts", "cells", static_cast<double>(times.size()), 0.0,
      exponent(products, times));
  for (const int contacts : {1, 16}) {
    std::vector<double> x, y;
    for (const int modes : {80, 320, 1280}) {
      x.push_back(modes);
      y.push_back(cost[{modes, contacts}]);
    }
    row("cost", "exponent of modes", "contacts", contacts, 0.0, exponent(x, y));
  }
  for (const int modes : {20, 1280}) {
    std::vector<double> x, y;
    for (const int contacts : all_contacts) {
      x.push_back(contacts);
      y.push_back(cost[{modes, contacts}]);
    }
    row("cost", "exponent of contacts", "modes", modes, 0.0, exponent(x, y));
  }
}

}  // namespace

int main() {
  fmt::print("study,method,knob,value,error,time\n");
  bench_wb1();
  bench_filter();
  bench_costs();
}
