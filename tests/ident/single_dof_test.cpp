#include "ident/single_dof.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

constexpr double k = 810.0, m = 0.84, c = 3.3;

TransferFunction stiffness(double decay = 0.0) {
  TransferFunction tf;
  tf.exponential_decay = decay;
  tf.frequency_hz = Eigen::VectorXd::LinSpaced(261, 1.5, 8.0);
  TransferFunction::Output output;
  output.name = "force";
  output.kind = FrfKind::dynamic_stiffness;
  output.unit = "N/m";
  output.value.resize(tf.lines());
  for (long i = 0; i < tf.lines(); ++i) {
    const std::complex<double> s(decay, 2.0 * std::numbers::pi * tf.frequency_hz[i]);
    output.value[i] = k + s * c + s * s * m;
  }
  tf.outputs = {output};
  return tf;
}

TEST(SingleDof, ExactDataGiveBackSpringMassAndDashpot) {
  for (const double decay : {0.0, 2.0}) {
    for (const StiffnessWeight weight : {StiffnessWeight::relative, StiffnessWeight::integrated}) {
      const SingleDof fit = fit_single_dof_stiffness(stiffness(decay), weight);
      EXPECT_NEAR(fit.stiffness / k, 1.0, 1e-11);  // rounding, the condition of the scaled columns squared
      EXPECT_NEAR(fit.mass / m, 1.0, 1e-11);
      EXPECT_NEAR(fit.damping / c, 1.0, 1e-11);
      EXPECT_NEAR(fit.natural_frequency_hz, std::sqrt(k / m) / (2.0 * std::numbers::pi), 1e-9);
      EXPECT_NEAR(fit.damping_ratio, c / (2.0 * std::sqrt(k * m)), 1e-9);
      EXPECT_LT(fit.scatter, 1e-11);
    }
  }
}

TEST(SingleDof, StandardErrorsAreTrue) {
  // 300 seeds: errors over their standard errors have unit variance within 8 % (one standard error of the
  // variance).
  for (const StiffnessWeight weight :
       {StiffnessWeight::relative, StiffnessWeight::integrated, StiffnessWeight::sigma}) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    for (int run = 0; run < 300; ++run) {
      TransferFunction tf = stiffness();
      auto& output = tf.outputs[0];
      output.sigma.resize(tf.lines());
      for (long i = 0; i < tf.lines(); ++i) {
        const double f = tf.frequency_hz[i];
        // The noise that each weight assumes; 1 % keeps 1/|D| of the measured D close to that of the true
        // one.
        output.sigma[i] = weight == StiffnessWeight::relative     ? 0.01 * std::abs(output.value[i])
                          : weight == StiffnessWeight::integrated ? 0.001 * f * f * std::abs(output.value[i])
                                                                  : 1.0 + 0.2 * f;
        output.value[i] += output.sigma[i] * std::complex<double>(normal(random), normal(random));
      }
      const SingleDof fit = fit_single_dof_stiffness(tf, weight);
      squares += Eigen::Vector3d((fit.stiffness - k) / fit.stiffness_sigma, (fit.mass - m) / fit.mass_sigma,
                                 (fit.damping - c) / fit.damping_sigma)
                     .cwiseAbs2();
    }
    for (long j = 0; j < 3; ++j) EXPECT_NEAR(squares[j] / 300.0, 1.0, 0.3) << j;
  }
}

TEST(SingleDof, AMassThatIsNegativeIsNotPhysical) {
  TransferFunction tf = stiffness();
  for (long i = 0; i < tf.lines(); ++i)
    tf.outputs[0].value[i] = 1.0 + tf.frequency_hz[i] * tf.frequency_hz[i];
  const SingleDof fit = fit_single_dof_stiffness(tf);
  EXPECT_FALSE(fit.physical());
  EXPECT_TRUE(std::isnan(fit.natural_frequency_hz));
}

TEST(SingleDof, WrongInputIsRefused) {
  TransferFunction tf = stiffness();
  EXPECT_THROW(fit_single_dof_stiffness(tf, StiffnessWeight::sigma), Error);
  tf.outputs[0].sigma = Eigen::VectorXd::Zero(tf.lines());
  EXPECT_THROW(fit_single_dof_stiffness(tf, StiffnessWeight::sigma), Error);
  tf.outputs[0].kind = FrfKind::receptance;
  EXPECT_THROW(fit_single_dof_stiffness(tf), Error);
  tf = stiffness();
  tf.outputs.push_back(tf.outputs[0]);
  EXPECT_THROW(fit_single_dof_stiffness(tf), Error);
  EXPECT_THROW(fit_single_dof_stiffness(restrict_band(stiffness(), 1.5, 1.53)), Error);
  tf = stiffness();
  tf.outputs[0].value[3] = 0.0;
  EXPECT_THROW(fit_single_dof_stiffness(tf), Error);
}

}  // namespace
}  // namespace struna::ident
