#include "ident/prediction_band.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "ident/parameter_file.hpp"
#include "simulated_experiment.hpp"

namespace struna::ident {
namespace {

using simulated::Coverages;
using simulated::Experiment;

const Eigen::VectorXd some_hz = Eigen::VectorXd::LinSpaced(20, 20.0, 120.0);

PredictionBand band_of(const synthetic::Wire& wire, const Eigen::VectorXd& frequency_hz, fem::Damping damping,
                       const IdentifiedParameters& p) {
  const auto response =
      fem::harmonic_response(wire.model, wire.drive, wire.measurement, frequency_hz, {damping, false});
  return prediction_band(wire.model, wire.drive, wire.measurement, response, damping, p);
}

IdentifiedParameters known(double modulus, double modulus_sigma, double eta, double eta_sigma) {
  IdentifiedParameters p;
  p.body = "wire";
  const auto law = [](double value, double sigma) {
    LawFit fit;
    fit.law = fem::constant_law(value);
    fit.covariance = Eigen::MatrixXd::Constant(1, 1, sigma * sigma);
    return fit;
  };
  p.modulus.laws = {law(modulus, modulus_sigma)};
  p.loss_factor.laws = {law(eta, eta_sigma)};
  return p;
}

TEST(PredictionBand, StiffnessDominatedResponseFollowsTheModulus) {
  // Far below the first resonance the dynamic stiffness is E(1 + i eta) times a constant.
  synthetic::Wire wire = synthetic::curved_wire(1, 20);
  const IdentifiedParameters p = known(1e11, 1e9, 0.02, 0.002);
  wire.model.body.material = apply(p, wire.model.body.material);
  const Eigen::VectorXd low = Eigen::VectorXd::Constant(1, 0.01);
  const PredictionBand band = band_of(wire, low, fem::Damping::structural, p);
  const std::complex<double> h =
      fem::harmonic_response(wire.model, wire.drive, wire.measurement, low).response(0, 0);
  // Inertia at 0.01 Hz: (0.01/24)^2.
  EXPECT_NEAR(band.real_sigma(0, 0) / std::abs(h.real()), 0.01, 1e-6);
  EXPECT_NEAR(band.imag_sigma(0, 0) / std::abs(h.imag()), std::hypot(0.01, 0.1), 1e-4);
  EXPECT_NEAR(band.magnitude_sigma(0, 0) / std::abs(h), 0.01, 1e-4);
  EXPECT_NEAR(band.sigma()(0, 0),
              std::sqrt(0.5 * (std::pow(band.real_sigma(0, 0), 2) + std::pow(band.imag_sigma(0, 0), 2))),
              1e-12 * std::abs(h));
}

TEST(PredictionBand, IsZeroWithoutCovarianceAndGrowsInProportion) {
  synthetic::Wire wire = synthetic::curved_wire(3, 15);
  const auto band = [&](const IdentifiedParameters& p) {
    wire.model.body.material = apply(p, wire.model.body.material);
    return band_of(wire, some_hz, fem::Damping::structural, p).sigma();
  };
  IdentifiedParameters unknown = known(1e11, 1e6, 0.02, 1e-5);
  const Eigen::MatrixXd one = band(unknown);
  EXPECT_GT(one.minCoeff(), 0.0);
  // Linear: steps of 1e-6 of the values leave 1e-9 or so.
  const Eigen::MatrixXd twice = band(known(1e11, 2e6, 0.02, 2e-5));
  EXPECT_LT(((twice - 2.0 * one).array() / one.array()).abs().maxCoeff(), 1e-3);
  unknown.modulus.laws[0].covariance.resize(0, 0);
  unknown.loss_factor.laws[0].covariance.resize(0, 0);
  EXPECT_EQ(band(unknown).maxCoeff(), 0.0);
}

TEST(PredictionBand, ViscousBandIsThatOfAlphaAndBetaTogether) {
  synthetic::Wire wire = synthetic::curved_wire(1, 15);
  IdentifiedParameters p = known(1e11, 0.0, 0.02, 0.0);
  p.rayleigh_known = p.rayleigh.determined = true;
  p.rayleigh.rayleigh = {10.0, 2e-5};
  p.rayleigh.alpha_sigma = 0.1;
  p.rayleigh.beta_sigma = 2e-7;
  const auto largest = [&](double correlation) {
    p.rayleigh.covariance = correlation * p.rayleigh.alpha_sigma * p.rayleigh.beta_sigma;
    wire.model.body.material = apply(p, wire.model.body.material);
    return band_of(wire, some_hz, fem::Damping::viscous, p).sigma().maxCoeff();
  };
  // Errors that offset each other leave less than errors that add up.
  EXPECT_GT(largest(0.0), 0.0);
  EXPECT_LT(largest(-0.9), largest(0.0));
  EXPECT_GT(largest(0.9), largest(0.0));
}

TEST(LawSigma, IsThatOfTheLawsOwnNumbers) {
  LawFit fit;
  fit.law = {fem::FrequencyLaw::Kind::power, {2e11, 0.1, 100.0}, {}, {}, 0.0, 0.0};
  fit.covariance = Eigen::Vector3d(1e18, 1e-4, 0.0).asDiagonal();
  const double f = 100.0 * std::numbers::e;  // d ln E = dc/c + dn
  EXPECT_NEAR(law_sigma(fit, f) / fit.law.at(f), std::hypot(1e9 / 2e11, 0.01), 1e-8);
  EXPECT_NEAR(law_sigma(fit, 100.0) / fit.law.at(100.0), 1e9 / 2e11, 1e-8);
  fit.covariance.resize(0, 0);
  EXPECT_EQ(law_sigma(fit, f), 0.0);
}

TEST(PredictionBand, CovarianceSurvivesTheParameterFile) {
  IdentifiedParameters p = known(1e11, 1e9, 0.02, 0.002);
  p.modulus.laws[0].law = {fem::FrequencyLaw::Kind::power, {2e11, 0.1, 100.0}, {}, {}, 0.0, 0.0};
  p.modulus.laws[0].covariance = Eigen::Matrix3d{{4e18, 3e7, 0.0}, {3e7, 1e-3, 0.0}, {0.0, 0.0, 0.0}};
  p.rayleigh_known = true;
  p.rayleigh.covariance = -1e-9;
  const std::string file = testing::TempDir() + "struna_covariance.toml";
  write_parameters(p, file);
  const IdentifiedParameters read = read_parameters(file);
  std::remove(file.c_str());
  EXPECT_EQ(read.modulus.laws[0].covariance, p.modulus.laws[0].covariance);
  EXPECT_EQ(read.loss_factor.laws[0].covariance, p.loss_factor.laws[0].covariance);
  EXPECT_EQ(read.rayleigh.covariance, p.rayleigh.covariance);
}

// The study of tests/bench/coverage_bench.cpp on a few experiments. Of 140 intervals at 95 %, 2.6 are lost by
// chance on either side (one standard deviation), of those that errors common to a run tie together more.
TEST(Coverage, StatedIntervalsHoldTheTruth) {
  const Experiment e = simulated::experiment();
  Coverages c;
  constexpr unsigned runs = 20;
  for (unsigned seed = 1; seed <= runs; ++seed) add_run(e, seed, c);
  EXPECT_EQ(c.lost_or_added, 0);
  EXPECT_GE(c.frequency.all, 100);
  for (const auto* coverage : {&c.frequency, &c.loss_factor, &c.modulus, &c.modulus_law, &c.prediction})
    EXPECT_GE(coverage->share(), 0.88);
  for (const auto* coverage : {&c.frequency, &c.loss_factor, &c.modulus}) EXPECT_LE(coverage->share(), 0.993);
}

}  // namespace
}  // namespace struna::ident
