// What the scene states with an error, carried into the modulus and the prediction: closed forms, and sets of
// scenes that are wrong by such errors.
#include "ident/body_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "ident/parameter_file.hpp"
#include "ident/prediction_band.hpp"
#include "tests/ident/stated_wire.hpp"

namespace struna::ident {
namespace {

using stated::Wire;

constexpr double diameter_sigma = 2e-5, length_sigma = 1e-3, density_sigma = 40.0;
// Within the modes' frequencies: beyond them the law's own spread adds to what the scene's errors make.
const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(24, 30.0, 110.0);

struct Predicted {
  Eigen::MatrixXcd response;
  PredictionBand band;
};

Predicted predicted(const Wire& scene, const IdentifiedParameters& identified) {
  const fem::Model model = fem::assemble(apply(identified, scene.body), stated::elements);
  const auto response = fem::harmonic_response(model, scene.drive, scene.measurement, lines);
  return {response.response, prediction_band(model, scene.drive, scene.measurement, response,
                                             fem::Damping::structural, identified)};
}

Wire off_by(Wire wire, const std::vector<double>& errors) {
  for (std::size_t k = 0; k < errors.size(); ++k) {
    fem::BodyNumber& number = wire.body.stated[k];
    const fem::BodyNumber before = number;
    wire.body = fem::moved(wire.body, before, errors[k]);
    wire.body.stated[k].value += errors[k];
  }
  return wire;
}

TEST(BodyErrors, OfAStraightWireAreThoseOfTheClosedForm) {
  // E = (2 pi f)^2 rho A L^4/((b L)^4 I): 2 sigma_d/d of a solid circle, 4 sigma_L/L, sigma_rho/rho.
  const struct {
    double diameter, length, density, relative;
  } cases[] = {{diameter_sigma, 0, 0, 2.0 * diameter_sigma / stated::diameter},
               {0, length_sigma, 0, 4.0 * length_sigma / 0.68},
               {0, 0, density_sigma, density_sigma / 7650.0}};
  for (const auto& c : cases) {
    const Wire wire = stated::wire(false, c.diameter, c.length, c.density);
    const ModeSet modes = stated::measured(wire, fem::constant_law(1e11), 600.0, 0.0, 1);
    const IdentifiedParameters p = stated::fitted(modes, wire, stated::bare());
    ASSERT_EQ(p.errors.size(), 1u);
    ASSERT_EQ(p.modulus.scene_sigma.size(), p.modulus.value.size());
    for (Eigen::Index i = 0; i < p.modulus.value.size(); ++i)  // differences of the matrices: 1e-4
      EXPECT_NEAR(p.modulus.scene_sigma[i] / p.modulus.value[i], c.relative, 1e-3 * c.relative);
    EXPECT_NEAR(std::abs(p.errors[0].level), c.relative, 1e-3 * c.relative);
    const fem::FrequencyLaw& law = p.modulus.laws.front().law;
    EXPECT_NEAR(law_sigma(law, p.errors, false, 50.0) / law.at(50.0), c.relative, 1e-3 * c.relative);
    EXPECT_EQ(law_sigma(law, p.errors, true, 50.0), 0.0);
    EXPECT_EQ(p.loss_factor.scene_sigma.size(), 0);  // damping is measured, not derived from the scene
  }
}

TEST(BodyErrors, NothingStatedChangesNothing) {
  const Wire wire = stated::wire(true);
  const ModeSet modes = stated::measured(wire, fem::constant_law(1e11), 200.0, 0.0, 1);
  const IdentifiedParameters p = stated::fitted(modes, wire, stated::bare());
  EXPECT_TRUE(p.errors.empty());
  EXPECT_EQ(p.modulus.scene_sigma.size(), 0);
}

TEST(BodyErrors, OneErrorAtATimeMovesWhatItIsSaidToMove) {
  const Wire truth = stated::wire(true, diameter_sigma, length_sigma, density_sigma);
  const ModeSet modes = stated::measured(truth, synthetic::true_modulus(), 200.0, 0.0, 1);
  const IdentifiedParameters at_truth = stated::fitted(modes, truth, stated::bare());
  const Predicted right = predicted(truth, at_truth);
  ASSERT_EQ(at_truth.errors.size(), 3u);
  Eigen::MatrixXd variance = Eigen::MatrixXd::Zero(lines.size(), 3);
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> error(3, 0.0);
    const double part = 0.1;  // second order terms are a hundredth
    error[k] = part * truth.body.stated[k].sigma;
    const Wire scene = off_by(truth, error);
    const IdentifiedParameters p = stated::fitted(modes, scene, stated::bare());
    ASSERT_EQ(p.modulus.value.size(), at_truth.modulus.value.size());
    const BodyErrorStep& step = at_truth.errors[k];
    for (Eigen::Index i = 0; i < p.modulus.value.size(); ++i) {
      EXPECT_NEAR(std::log(p.modulus.value[i] / at_truth.modulus.value[i]) / part, step.modulus[i],
                  0.02 * std::abs(step.level));
    }
    // Damping is read off the resonances alone.
    EXPECT_NEAR(p.rayleigh.rayleigh.alpha, at_truth.rayleigh.rayleigh.alpha,
                1e-4 * at_truth.rayleigh.alpha_sigma);
    EXPECT_NEAR(p.rayleigh.rayleigh.beta, at_truth.rayleigh.rayleigh.beta,
                1e-4 * at_truth.rayleigh.beta_sigma);
    variance += ((predicted(scene, p).response - right.response) / part).cwiseAbs2();
  }
  // sigma() is per part of the complex number. The noise's share is 1e-6.
  const Eigen::MatrixXd stated_sigma = std::sqrt(2.0) * right.band.sigma();
  const Eigen::MatrixXd ratio = stated_sigma.cwiseQuotient(variance.cwiseSqrt());
  EXPECT_LT(ratio.maxCoeff(), 1.05);
  EXPECT_GT(ratio.minCoeff(), 0.95);
}

TEST(BodyErrors, ScatterOverWrongScenesIsTheOneStated) {
  const Wire truth = stated::wire(true, diameter_sigma, length_sigma, density_sigma);
  const ModeSet modes = stated::measured(truth, synthetic::true_modulus(), 120.0, 0.0, 1);
  const IdentifiedParameters at_truth = stated::fitted(modes, truth, stated::bare());
  const Predicted right = predicted(truth, at_truth);
  constexpr int seeds = 30;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  double modulus = 0.0;
  Eigen::MatrixXd magnitude = Eigen::MatrixXd::Zero(lines.size(), 3);
  for (int seed = 0; seed < seeds; ++seed) {
    const Wire scene = off_by(truth, {diameter_sigma * normal(random), length_sigma * normal(random),
                                      density_sigma * normal(random)});
    const IdentifiedParameters p = stated::fitted(modes, scene, stated::bare());
    modulus += std::pow(p.modulus.value[0] - at_truth.modulus.value[0], 2) / seeds;
    magnitude += (predicted(scene, p).response.cwiseAbs() - right.response.cwiseAbs()).cwiseAbs2() / seeds;
  }
  // A standard deviation out of 30 is known to 1/sqrt(60) = 13 %.
  EXPECT_NEAR(std::sqrt(modulus) / at_truth.modulus.scene_sigma[0], 1.0, 0.4);
  const Eigen::MatrixXd ratio = magnitude.cwiseSqrt().cwiseQuotient(right.band.magnitude_sigma);
  EXPECT_NEAR(ratio.mean(), 1.0, 0.4);
}

TEST(BodyErrors, OfAnotherBodyTheModulusErrorStandsAlone) {
  // Counted without the body's own error, that of the modulus shifts the resonances.
  const Wire wire = stated::wire(true, diameter_sigma, 0.0, 0.0);
  const ModeSet modes = stated::measured(wire, synthetic::true_modulus(), 120.0, 0.0, 1);
  const IdentifiedParameters p = stated::fitted(modes, wire, stated::bare());
  Wire other = wire;
  other.body.stated[0].value *= 1.001;  // another wire's diameter, as far as anyone can tell
  other.body.stated[0].sigma = 0.0;
  const Eigen::VectorXd size = predicted(wire, p).response.col(0).cwiseAbs();
  const Eigen::VectorXd same = predicted(wire, p).band.sigma().col(0).cwiseQuotient(size);
  const Eigen::VectorXd apart = predicted(other, p).band.sigma().col(0).cwiseQuotient(size);
  // The level of the force goes with the mass, 2 sigma_d/d, and a tenth more at lines on the flank of a
  // resonance; a shift of 1.25 % in E is much against 1 % of
  // loss.
  EXPECT_NEAR(same.mean() * std::sqrt(2.0) / (2.0 * diameter_sigma / stated::diameter), 1.0, 0.15);
  EXPECT_GT(apart.maxCoeff(), 10.0 * same.maxCoeff());
}

TEST(BodyErrors, SurviveTheParameterFile) {
  const Wire wire = stated::wire(true, diameter_sigma, length_sigma, 0.0);
  const ModeSet modes = stated::measured(wire, synthetic::true_modulus(), 120.0, 1e-4, 1);
  FitOptions options = stated::bare();
  options.free = {"torsion_constant"};
  const IdentifiedParameters p = stated::fitted(modes, wire, options);
  const std::string file = testing::TempDir() + "struna_body_errors.toml";
  write_parameters(p, file);
  const IdentifiedParameters read = read_parameters(file);
  std::remove(file.c_str());
  EXPECT_EQ(read.modulus.scene_sigma, p.modulus.scene_sigma);
  EXPECT_EQ(read.modulus.fitted_sigma, p.modulus.fitted_sigma);
  EXPECT_EQ(read.fitted.name, p.fitted.name);
  EXPECT_EQ(read.fitted.value, p.fitted.value);
  EXPECT_EQ(read.fitted.covariance, p.fitted.covariance);
  ASSERT_EQ(read.errors.size(), p.errors.size());
  for (std::size_t k = 0; k < p.errors.size(); ++k) {
    EXPECT_EQ(read.errors[k].of, p.errors[k].of);
    EXPECT_EQ(read.errors[k].value, p.errors[k].value);
    EXPECT_EQ(read.errors[k].number, p.errors[k].number);
    EXPECT_EQ(read.errors[k].change, p.errors[k].change);
    EXPECT_EQ(read.errors[k].law_step, p.errors[k].law_step);
  }
  EXPECT_EQ(predicted(wire, read).band.sigma(), predicted(wire, p).band.sigma());
}

}  // namespace
}  // namespace struna::ident
