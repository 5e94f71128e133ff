#include "ident/rayleigh_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "fem/error.hpp"
#include "ident/rayleigh_flag.hpp"

namespace struna::ident {
namespace {

Eigen::VectorXd vector(std::initializer_list<double> values) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.data());
  return v;
}

const Eigen::VectorXd wire_frequency = vector({16.8, 22.9, 42.4, 70.7, 134.4, 218.2, 316.7, 557.2, 857.6});

Eigen::VectorXd damping_ratio(const fem::Rayleigh& rayleigh, const Eigen::VectorXd& frequency) {
  return frequency.unaryExpr([&](double f) { return fem::rayleigh_damping_ratio(rayleigh, f); });
}

TEST(RayleighFit, RecoversTheCoefficientsOfExactData) {
  const fem::Rayleigh truth{43.1, 2e-6};
  const Eigen::VectorXd zeta = damping_ratio(truth, wire_frequency);
  const RayleighFit fit = fit_rayleigh(wire_frequency, zeta, 0.01 * zeta);
  // Rounding times the condition of the scaled columns (below 1e2).
  EXPECT_NEAR(fit.rayleigh.alpha / truth.alpha, 1.0, 1e-12);
  EXPECT_NEAR(fit.rayleigh.beta / truth.beta, 1.0, 1e-12);
  EXPECT_TRUE(fit.determined);
  EXPECT_FALSE(fit.alpha_at_bound);
  EXPECT_FALSE(fit.beta_at_bound);
  EXPECT_LT(fit.rms, 1e-10);
}

TEST(RayleighFit, IsFlaggedWhereModesAreTooFewOrContradictIt) {
  const fem::Rayleigh truth{43.1, 2e-6};
  const auto flag_of = [&](const Eigen::VectorXd& frequency, double constant) {
    const Eigen::VectorXd zeta =
        damping_ratio(truth, frequency) + Eigen::VectorXd::Constant(frequency.size(), constant);
    return rayleigh_flag(fit_rayleigh(frequency, zeta, 0.01 * zeta));
  };
  EXPECT_EQ(flag_of(wire_frequency, 0.0), RayleighFlag::none);
  EXPECT_EQ(flag_of(wire_frequency, 0.05), RayleighFlag::contradicted);
  EXPECT_EQ(flag_of(vector({20.0, 200.0}), 0.0), RayleighFlag::two_modes);
  EXPECT_EQ(flag_of(vector({20.0}), 0.0), RayleighFlag::one_mode);
  EXPECT_EQ(to_string(RayleighFlag::contradicted), "contradicted");
  EXPECT_EQ(to_string(RayleighFlag::none), "");
}

TEST(RayleighFit, NoiseAloneDoesNotContradictAndABoundDoes) {
  // Modes known to 8 % of true Rayleigh damping: chance < 0.001, so one fit in 400 at most with luck.
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  int contradicted = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Eigen::VectorXd zeta = damping_ratio({20.0, 8e-6}, wire_frequency);
    const Eigen::VectorXd sigma = 0.08 * zeta;
    for (long i = 0; i < zeta.size(); ++i) zeta[i] += sigma[i] * normal(random);
    contradicted += rayleigh_flag(fit_rayleigh(wire_frequency, zeta, sigma)) == RayleighFlag::contradicted;
  }
  EXPECT_LE(contradicted, 2);
  // Damping that rises as f^1.5 asks for a negative alpha; held at zero, two modes have one degree of freedom.
  const RayleighFit bound = fit_rayleigh(vector({50.0, 200.0}), vector({0.005, 0.04}), vector({5e-5, 4e-4}));
  ASSERT_TRUE(bound.alpha_at_bound);
  EXPECT_EQ(rayleigh_flag(bound), RayleighFlag::contradicted);
}

TEST(RayleighFit, MisfitIsTheCurvesOwnErrorHoweverWellTheModesAreKnown) {
  // Constant damping at three frequencies, the outer two equally far from the middle one in ln f: the curve
  // runs above it there and below at the ends, and the noise that is allowed for is subtracted in square.
  const Eigen::VectorXd f = vector({50.0, 100.0, 200.0}), zeta = Eigen::VectorXd::Constant(3, 0.01);
  const auto misfit_at = [&](double sigma) { return fit_rayleigh(f, zeta, sigma * zeta).misfit; };
  const fem::Rayleigh best = rayleigh_pseudo_inverse(f, zeta);
  const double off =
      (damping_ratio(best, f) / 0.01 - Eigen::VectorXd::Ones(3)).norm();  // one degree of freedom
  EXPECT_GT(off, 0.1);
  EXPECT_NEAR(misfit_at(1e-6), off, 1e-6);
  EXPECT_NEAR(misfit_at(0.1), std::sqrt(off * off - 0.01), 1e-6);
  EXPECT_EQ(misfit_at(0.5), 0.0);
  EXPECT_EQ(fit_rayleigh(f.head(2), zeta.head(2), 0.01 * zeta.head(2)).misfit, 0.0);
}

TEST(RayleighFit, EqualsThePseudoInverseWithEqualWeightsAndNoActiveBound) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    Eigen::VectorXd zeta = damping_ratio({20.0, 8e-6}, wire_frequency);
    for (double& z : zeta) z *= 1.0 + 0.05 * normal(random);
    const RayleighFit fit = fit_rayleigh(wire_frequency, zeta, Eigen::VectorXd::Constant(zeta.size(), 1e-3));
    const fem::Rayleigh expected = rayleigh_pseudo_inverse(wire_frequency, zeta);
    ASSERT_FALSE(fit.alpha_at_bound || fit.beta_at_bound);
    EXPECT_NEAR(fit.rayleigh.alpha / expected.alpha, 1.0, 1e-10);  // rounding times condition
    EXPECT_NEAR(fit.rayleigh.beta / expected.beta, 1.0, 1e-10);
  }
}

TEST(RayleighFit, PseudoInverseSolvesTheNormalEquations) {
  Eigen::VectorXd zeta = damping_ratio({20.0, 8e-6}, wire_frequency);
  zeta[2] *= 1.3;
  const fem::Rayleigh fit = rayleigh_pseudo_inverse(wire_frequency, zeta);
  const Eigen::ArrayXd omega = 2.0 * std::numbers::pi * wire_frequency.array();
  const Eigen::ArrayXd residual = damping_ratio(fit, wire_frequency) - zeta;
  // Orthogonal to both columns, relative to the sizes multiplied: rounding.
  EXPECT_NEAR((residual / omega).sum() / (zeta.array() / omega).sum(), 0.0, 1e-13);
  EXPECT_NEAR((residual * omega).sum() / (zeta.array() * omega).sum(), 0.0, 1e-13);
}

TEST(RayleighFit, HoldsANegativeCoefficientAtZeroAndRefitsTheOther) {
  const Eigen::VectorXd rising = 1e-5 * wire_frequency.array().pow(1.3);  // wants alpha < 0
  const Eigen::VectorXd sigma = Eigen::VectorXd::Constant(rising.size(), 1e-4);
  ASSERT_LT(rayleigh_pseudo_inverse(wire_frequency, rising).alpha, 0.0);
  const RayleighFit fit = fit_rayleigh(wire_frequency, rising, sigma);
  EXPECT_TRUE(fit.alpha_at_bound);
  EXPECT_EQ(fit.rayleigh.alpha, 0.0);
  EXPECT_EQ(fit.alpha_sigma, 0.0);
  const Eigen::VectorXd half_omega = std::numbers::pi * wire_frequency;
  EXPECT_NEAR(fit.rayleigh.beta / (half_omega.dot(rising) / half_omega.squaredNorm()), 1.0,
              1e-10);  // Ceres' stop

  const Eigen::VectorXd falling = wire_frequency.array().pow(-1.3);  // wants beta < 0
  ASSERT_LT(rayleigh_pseudo_inverse(wire_frequency, falling).beta, 0.0);
  const RayleighFit other = fit_rayleigh(wire_frequency, falling, sigma);
  EXPECT_TRUE(other.beta_at_bound);
  EXPECT_EQ(other.rayleigh.beta, 0.0);
  EXPECT_GT(other.rayleigh.alpha, 0.0);
}

TEST(RayleighFit, StandardErrorsMatchTheScatterOverSeeds) {
  const fem::Rayleigh truth{43.1, 2e-6};
  const Eigen::VectorXd zeta = damping_ratio(truth, wire_frequency);
  const Eigen::VectorXd sigma = 0.03 * zeta;
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const int seeds = 2000;
  double alpha_square = 0.0, beta_square = 0.0, alpha_said = 0.0, beta_said = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    Eigen::VectorXd noisy = zeta;
    for (Eigen::Index i = 0; i < noisy.size(); ++i) noisy[i] += sigma[i] * normal(random);
    const RayleighFit fit = fit_rayleigh(wire_frequency, noisy, sigma);
    alpha_square += std::pow(fit.rayleigh.alpha - truth.alpha, 2);
    beta_square += std::pow(fit.rayleigh.beta - truth.beta, 2);
    alpha_said += fit.alpha_sigma;
    beta_said += fit.beta_sigma;
  }
  // 2000 seeds: sd known to 1.6 %; the errors are enlarged by misfits above 1, 12 % on average with 7 degrees
  // of freedom.
  EXPECT_NEAR(alpha_said / seeds / std::sqrt(alpha_square / seeds), 1.12, 0.08);
  EXPECT_NEAR(beta_said / seeds / std::sqrt(beta_square / seeds), 1.12, 0.08);
}

TEST(RayleighFit, OneModeDeterminesBetaAlone) {
  const RayleighFit fit = fit_rayleigh(vector({100.0}), vector({0.02}), vector({0.001}));
  EXPECT_FALSE(fit.determined);
  EXPECT_EQ(fit.rayleigh.alpha, 0.0);
  EXPECT_TRUE(std::isinf(fit.alpha_sigma));
  EXPECT_NEAR(fem::rayleigh_damping_ratio(fit.rayleigh, 100.0), 0.02, 1e-16);
  EXPECT_NEAR(fit.beta_sigma / fit.rayleigh.beta, 0.05, 1e-12);
  const RayleighFit twice =
      fit_rayleigh(vector({100.0, 100.0}), vector({0.02, 0.02}), vector({0.001, 0.001}));
  EXPECT_FALSE(twice.determined);
  EXPECT_NEAR(twice.beta_sigma, fit.beta_sigma / std::sqrt(2.0), 1e-15);
}

TEST(RayleighFit, RefusesWhatIsNoData) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fit_rayleigh({}, {}, {}), Error);
  EXPECT_THROW(fit_rayleigh(vector({1, 2}), vector({0.1}), vector({0.1, 0.1})), Error);
  EXPECT_THROW(fit_rayleigh(vector({1, 2}), vector({0.1, 0.1}), vector({0.1})), Error);
  EXPECT_THROW(fit_rayleigh(vector({0, 2}), vector({0.1, 0.1}), vector({0.1, 0.1})), Error);
  EXPECT_THROW(fit_rayleigh(vector({1, 2}), vector({-0.1, 0.1}), vector({0.1, 0.1})), Error);
  EXPECT_THROW(fit_rayleigh(vector({1, 2}), vector({0.1, 0.1}), vector({0.0, 0.1})), Error);
  EXPECT_THROW(fit_rayleigh(vector({1, 2}), vector({0.1, nan}), vector({0.1, 0.1})), Error);
  EXPECT_THROW(rayleigh_pseudo_inverse(vector({1, 2}), vector({0.1})), Error);
}

}  // namespace
}  // namespace struna::ident
