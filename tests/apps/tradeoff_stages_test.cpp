// What the charts say, on the accuracy side: errors that have a cause, references that have converged, and
// where the default stands. Times are never asserted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "apps/shaken_wire.hpp"
#include "apps/tradeoff_harmonic.hpp"
#include "apps/tradeoff_model.hpp"
#include "apps/tradeoff_modes.hpp"
#include "apps/tradeoff_simulation.hpp"
#include "apps/tradeoff_transfer.hpp"
#include "fem/closed_forms.hpp"

namespace struna::apps {
namespace {

/// Each thing once: times are not looked at.
TradeoffRun once() {
  TradeoffRun run;
  run.timing = {1, 0.0};
  return run;
}

const TradeoffRow* default_row(const TradeoffChart& chart) {
  for (const auto& row : chart.rows) {
    if (row.is_default) return &row;
  }
  return nullptr;
}

double error_of(const TradeoffChart& chart, const std::string& method, double value) {
  for (const auto& row : chart.rows) {
    if (row.method == method && row.value == value) return row.error;
  }
  ADD_FAILURE() << "no row " << method << " " << value << " in " << chart_title(chart);
  return std::nan("");
}

/// Up to 300 Hz only: fewer modes and elements, the same laws.
LinearProblem narrow(LinearProblem problem) {
  problem.band.hi_hz = 300.0;
  return problem;
}

TEST(TradeoffModel, ReferenceOfTheStraightWireIsTheClosedForm) {
  const LinearProblem problem = narrow(straight_wire_problem());
  const LinearReference reference = linear_reference(problem, 50);
  const ShakenWire wire;
  ASSERT_EQ(reference.natural_frequency_hz.size(), 8);
  // Each bending mode twice, once in every plane.
  for (int mode = 1; mode <= 4; ++mode) {
    const double exact = fem::natural_frequency_hz(wire.beam, mode);
    EXPECT_NEAR(reference.natural_frequency_hz(2 * mode - 1) / exact, 1.0, 2e-7) << mode;  // rounding, ~n^4
  }
  double worst = 0.0;
  for (long i = 0; i < reference.line_hz.size(); ++i) {
    const auto exact = fem::far_support_stiffness(wire.beam, 0.02, reference.line_hz(i));
    worst = std::max(worst, std::abs(reference.response(i, 1) - exact) / std::abs(exact));
  }
  // A frequency error e is a response error of up to 2 e/eta at a resonance.
  EXPECT_LT(worst, 2e-5);
  EXPECT_LT(reference.response_error, 2e-5);
  EXPECT_LT(reference.frequency_error, 1e-6);
}

TEST(TradeoffModel, MeshesOfAStraightWireConvergeAtTheirOrders) {
  const auto charts = tradeoff_model(narrow(straight_wire_problem()), once());
  ASSERT_EQ(charts.size(), 2u);
  // Hermite elements: 4th order; the lumped mass: 2nd. From 24 to 48 elements, within what the coarser mesh's
  // next term leaves.
  const auto order = [&](const std::string& method) {
    return std::log2(error_of(charts[0], method, 24) / error_of(charts[0], method, 48));
  };
  EXPECT_NEAR(order("straight elements; consistent mass"), 4.0, 0.15);
  EXPECT_NEAR(order("straight elements; lumped mass"), 2.0, 0.25);
}

TEST(TradeoffModel, TheDefaultMeshIsTheMostAccurateOfItsSize) {
  for (const auto& problem : {narrow(straight_wire_problem()), narrow(spline_wire_problem())}) {
    for (const auto& chart : tradeoff_model(problem, once())) {
      const TradeoffRow* const usual = default_row(chart);
      ASSERT_NE(usual, nullptr) << chart_title(chart);
      for (const auto& row : chart.rows) {
        if (row.value <= usual->value) {
          EXPECT_GE(1.5 * row.error, usual->error) << row.method << row.value;
        }
      }
      EXPECT_LT(usual->error, 1e-2) << chart_title(chart);
      EXPECT_LT(chart.reference_error, 0.1 * usual->error) << chart_title(chart);
    }
  }
}

TEST(TradeoffModel, ChordsInsteadOfTheCurveCostMoreThanAllElse) {
  const auto charts = tradeoff_model(narrow(spline_wire_problem()), once());
  // 4e-4 to 2e-3 at 28 straight elements, docs/beam_element.md, falling as h^2.
  const double chords = error_of(charts[0], "straight chords; consistent mass", 32);
  EXPECT_GT(chords, 1e-4);
  EXPECT_GT(chords, 2.0 * error_of(charts[0], "curved elements; consistent mass", 32));
}

TEST(TradeoffModel, LumpedMassKeepsTheBodysMass) {
  const fem::Body body = spline_wire_problem().body;
  for (const auto kind : {MeshKind::curved_lumped, MeshKind::chords_lumped}) {
    const fem::Model model = tradeoff_mesh(body, 40, kind);
    Eigen::VectorXd along = Eigen::VectorXd::Zero(model.dof_count());
    for (long i = 0; i < along.size(); i += 6) along[i] = 1.0;
    const double mass = along.dot(fem::multiply(model.mass, along).col(0));
    double length = body.centreline.length();
    if (kind == MeshKind::chords_lumped) {
      length = 0.0;
      for (std::size_t i = 1; i < model.position.size(); ++i)
        length += (model.position[i] - model.position[i - 1]).norm();
    }
    EXPECT_NEAR(mass, body.density * body.section.area * length, 1e-12);
  }
}

TEST(TradeoffHarmonic, CompleteModalSumsAreTheDirectSolution) {
  const LinearProblem problem = spline_wire_problem();
  const fem::Model model = fem::assemble(problem.body, 24);
  const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(60, 10.0, 900.0);
  const auto direct = fem::harmonic_response(model, problem.drive, problem.measurement, lines).response;
  const int all = static_cast<int>(model.free_dof.size());
  // Rounding of the modes, amplified at resonances.
  EXPECT_LT(response_error(modal_response(problem, model, all, ModalSum::static_correction, lines), direct),
            1e-7);
  EXPECT_LT(response_error(modal_response(problem, model, all, ModalSum::plain, lines), direct), 1e-6);
}

TEST(TradeoffHarmonic, StaticCorrectionSavesModes) {
  const LinearProblem problem = straight_wire_problem();
  const fem::Model model = fem::assemble(problem.body, 40);
  const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(60, 10.0, 500.0);
  const auto direct = fem::harmonic_response(model, problem.drive, problem.measurement, lines).response;
  const double plain = response_error(modal_response(problem, model, 24, ModalSum::plain, lines), direct);
  const double corrected =
      response_error(modal_response(problem, model, 24, ModalSum::static_correction, lines), direct);
  EXPECT_GT(plain, 10.0 * corrected);
}

TEST(TradeoffHarmonic, RefusesWhatIsNotASupport) {
  LinearProblem problem = straight_wire_problem();
  problem.drive = fem::PointForce{0.5, Eigen::Vector3d::UnitY()};
  const fem::Model model = fem::assemble(problem.body, 8);
  const Eigen::VectorXd line = Eigen::VectorXd::Constant(1, 50.0);
  EXPECT_THROW(modal_response(problem, model, 8, ModalSum::plain, line), Error);
  const auto charts = tradeoff_harmonic(problem, once());
  ASSERT_EQ(charts.size(), 1u);
  EXPECT_FALSE(charts[0].notes.empty());
  EXPECT_NE(default_row(charts[0]), nullptr);
}

TEST(TradeoffModes, TheDefaultFindsEveryModeAndIsTheMostAccurate) {
  const auto charts = tradeoff_modes(eight_modes_problem(0.01, 1), once());
  ASSERT_EQ(charts.size(), 2u);
  for (const auto& chart : charts) {
    const TradeoffRow* const usual = default_row(chart);
    ASSERT_NE(usual, nullptr);
    // The Cramer-Rao bound's median is 0.03 % in eta and 2e-6 in frequency; weak modes have several of it.
    EXPECT_LT(usual->error, chart.quantity == "loss factor" ? 3e-3 : 3e-5);
    for (const auto& row : chart.rows) EXPECT_LT(usual->error, 1.5 * row.error) << row.method << row.value;
  }
}

TEST(TradeoffModes, AMeasuredFunctionIsComparedWithItsOwnModes) {
  const auto problem = measured_modes_problem(eight_modes_problem(0.01, 1).draws.front(), "function");
  EXPECT_GE(problem.truth.size(), 7u);
  EXPECT_GT(problem.loss_factor_reference_error, 0.0);
  for (const auto& chart : tradeoff_modes(problem, once())) {
    EXPECT_GT(chart.reference_error, 0.0);
    EXPECT_EQ(default_row(chart)->error, 0.0) << "the default on all lines is the reference";
    EXPECT_EQ(told_error(chart, *default_row(chart)), chart.reference_error);
  }
}

TEST(TradeoffModes, NearestModeLiesWithinABandwidth) {
  ident::Mode truth, near, far;
  truth.natural_frequency_hz = 100.0;
  truth.loss_factor = 0.01;
  near.natural_frequency_hz = 100.9;
  far.natural_frequency_hz = 101.1;
  EXPECT_EQ(nearest_mode({far}, truth), nullptr);
  const std::vector<ident::Mode> both = {far, near};
  EXPECT_EQ(nearest_mode(both, truth), &both[1]);
}

TEST(ShakenWire, RecordHasTheClosedFormAsItsTransferFunction) {
  const ShakenWire wire;
  const auto record = wire.record(20.0, 10.0, 700.0, {0.0, 0.0}, 1);
  EXPECT_EQ(record.samples.rows(), 40000);
  ident::WelchOptions options;
  options.resolution_hz = 0.5;
  const auto tf = ident::restrict_band(
      ident::estimate_transfer_function(ident::welch_spectra(record, "displacement", {"force_y"}, options),
                                        ident::Estimator::h1),
      90.0, 110.0);
  // Between the resonances at 67 and 132 Hz nothing but leakage from the band's strong low end is left.
  for (long i = 0; i < tf.lines(); ++i) {
    const auto exact = fem::far_support_stiffness(wire.beam, wire.loss_factor, tf.frequency_hz(i));
    EXPECT_LT(std::abs(tf.outputs[0].value(i) - exact), 0.05 * std::abs(exact)) << tf.frequency_hz(i);
  }
  EXPECT_THROW(wire.record(20.0, 10.0, 900.0, {}, 1), Error);
  EXPECT_THROW(wire.record(0.0, 10.0, 700.0, {}, 1), Error);
}

TEST(TradeoffTransfer, TheDefaultIsTheMostAccurateOfItsResolution) {
  const auto chart = tradeoff_resolution(shaken_wire_problem(30.0, 0.01, 1), once());
  const TradeoffRow* const usual = default_row(chart);
  ASSERT_NE(usual, nullptr);
  EXPECT_LT(usual->error, 0.05);
  // A Hann window of 2 lines per half-power bandwidth (mode 1) inflates eta by tens of per cent.
  EXPECT_GT(error_of(chart, "h1; Hann", 0.25), 2.0 * usual->error);
}

TEST(TradeoffSimulation, TheWireAgainstItsStopConvergesToThePublishedPath) {
  const TradeoffChart chart = wire_against_stop(0.1, once());
  EXPECT_LT(chart.reference_error, 1e-3);
  // Published for this problem: 6e-3 (2e-5) and 2.3e-3 (1e-5) with Newmark cut by five, over five times as
  // long.
  EXPECT_LT(error_of(chart, "newmark", 1e-5), 1e-2);
  // Second order: a fifth of the step, 25 times less.
  const double ratio = error_of(chart, "modal; fixed step (cut 20)", 1e-4) /
                       error_of(chart, "modal; fixed step (cut 20)", 2e-5);
  EXPECT_GT(ratio, 8.0);
  const TradeoffRow* const usual = default_row(chart);
  ASSERT_NE(usual, nullptr);
  EXPECT_LT(usual->error, 5e-3);
}

}  // namespace
}  // namespace struna::apps
