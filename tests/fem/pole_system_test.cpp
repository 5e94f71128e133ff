#include "fem/pole_system.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;
constexpr double two_pi = 2.0 * std::numbers::pi;

FrequencyLaw power_law(double c, double n) {
  FrequencyLaw law;
  law.kind = FrequencyLaw::Kind::power;
  law.parameters = {c, n, 100.0};
  return law;
}

/// A body that is only its material, with modes at the given frequencies.
struct Modes {
  Model model{
      Body{"wire", straight_line({0, 0, 0}, {1, 0, 0}), {}, 1.0, 0.3, {}, 0, {}, {}}, {}, {}, {}, {}, {}, {}};
  Eigenmodes modes;

  Modes(const Material& material, const std::vector<double>& f_hz) {
    model.body.material = material;
    modes.eigenvalue.resize(static_cast<long>(f_hz.size()));
    for (std::size_t m = 0; m < f_hz.size(); ++m) {
      const double omega = two_pi * f_hz[m];
      modes.eigenvalue[static_cast<long>(m)] =
          f_hz[m] > 0.0 ? omega * omega / material.youngs_modulus.at(f_hz[m]) : 0.0;
    }
  }
  PoleSystem poles(Damping damping, double hi = 1000.0) const {
    return pole_system(model, modes, damping, hi);
  }
};

Material viscous_material(double alpha, double beta) {
  Material material;
  material.youngs_modulus = constant_law(1e11);
  material.rayleigh = {alpha, beta};
  material.damping = Damping::viscous;
  return material;
}

Material strand(double n, double eta) {
  Material material;
  material.youngs_modulus = power_law(1e11, n);
  material.loss_factor = constant_law(eta);
  return material;
}

TEST(PoleSystem, ViscousModesHaveTheReceptanceOfTheirOscillator) {
  // From undamped over critical (f0 = alpha/(4 pi) with beta = 0) to overdamped.
  for (const double alpha : {0.0, 43.1, 4.0 * std::numbers::pi * 50.0, 2000.0}) {
    const Modes body(viscous_material(alpha, 2e-6), {20.0, 50.0, 400.0});
    const auto system = body.poles(Damping::viscous);
    for (int m = 0; m < 3; ++m) {
      const double w0 = two_pi * system.natural_frequency_hz[m];
      for (const double f : {1.0, 30.0, 300.0, 3000.0}) {
        const double w = two_pi * f;
        const Complex exact = 1.0 / Complex(w0 * w0 - w * w, w * (alpha + 2e-6 * w0 * w0));
        // Rounding, times 1/sqrt(1e-9) where the poles nearly coincide, plus the shift of 1e-9 itself.
        EXPECT_LT(std::abs(modal_receptance(system, m, f) / exact - 1.0), 1e-8)
            << alpha << ' ' << m << ' ' << f;
      }
    }
  }
}

TEST(PoleSystem, RigidModeIsAFreeMass) {
  for (const double alpha : {0.0, 10.0}) {
    const Modes body(viscous_material(alpha, 1e-6), {0.0, 50.0});
    const auto system = body.poles(Damping::viscous);
    EXPECT_EQ(system.relaxed_stiffness[0], 0.0);
    const double w = two_pi * 5.0;
    const Complex exact = 1.0 / Complex(-w * w, w * alpha);
    EXPECT_LT(std::abs(modal_receptance(system, 0, 5.0) / exact - 1.0), 1e-14);  // rounding
    EXPECT_TRUE(is_rigid_pole(system, 0, 1));
    EXPECT_FALSE(is_rigid_pole(system, 1, 2));
    EXPECT_EQ(system.rest_stiffness[0], 0.0);
  }
}

TEST(PoleSystem, MeetsModulusAndLossFactorAtEachResonance) {
  const Modes body(strand(0.02, 0.0374), {17.0, 60.0, 160.0, 900.0, 4000.0});
  const auto system = body.poles(Damping::structural);
  for (int m = 0; m < 5; ++m) {
    const double w = two_pi * system.natural_frequency_hz[m];
    const Complex exact = 1.0 / Complex(0.0, w * w * 0.0374);  // lambda E (1 + i eta) - w^2 = i w^2 eta
    // Rounding, amplified by 1/eta and by the spread of the relaxation times.
    EXPECT_LT(std::abs(modal_receptance(system, m, system.natural_frequency_hz[m]) / exact - 1.0), 1e-9) << m;
  }
}

TEST(PoleSystem, ResiduesCancelAndGiveUnitMass) {
  for (const auto damping : {Damping::structural, Damping::viscous}) {
    auto material = strand(0.02, 0.0374);
    material.rayleigh = {43.1, 2e-6};
    const Modes body(material, {17.0, 160.0, 900.0});
    const auto system = body.poles(damping);
    for (int m = 0; m < 3; ++m) {
      double sum = 0.0, size = 0.0, momentum = 0.0;
      for (long k = 0; k < system.pole.size(); ++k) {
        if (system.mode[k] != m) continue;
        EXPECT_LT(system.pole[k].real(), 0.0);
        sum += system.residue[k].real();
        size += std::abs(system.residue[k]);
        momentum += (system.residue[k] * system.pole[k]).real();
      }
      EXPECT_LT(std::abs(sum), 1e-10 * size);  // rounding of the eigenvalues
      EXPECT_NEAR(momentum, 1.0, 1e-9);
    }
  }
}

TEST(PoleSystem, StaticResponseIsTheRelaxedStiffness) {
  const Modes body(strand(0.02, 0.0374), {17.0, 160.0});
  const auto system = body.poles(Damping::structural);
  for (int m = 0; m < 2; ++m) {
    const double flexibility = modal_receptance(system, m, 1e-9).real();
    EXPECT_NEAR(flexibility * system.relaxed_stiffness[m], 1.0, 1e-7);  // 1e-9 Hz is not quite zero
  }
}

TEST(PoleSystem, MeetsEveryExponentAndLossFactorHoweverFarAboveTheBand) {
  // Modes up to 10^4 times the band's edge; eta from far below to far above what E ~ f^n demands.
  for (const double n : {0.0, 0.02, 0.1}) {
    for (const double eta : {0.01, 0.03, 0.05, 0.1, 0.3, 1.0}) {
      for (const double hi : {10.0, 30.0, 100.0, 900.0}) {
        const Modes body(strand(n, eta), {31.0, 86.0, 808.0, 3000.0, 1e5});
        const auto system = body.poles(Damping::structural, hi);
        for (int m = 0; m < 5; ++m) {
          const double f = system.natural_frequency_hz[m];
          const Complex exact = 1.0 / Complex(0.0, two_pi * f * two_pi * f * eta);
          // Rounding of the poles, amplified by 1/eta and the spread of the relaxation times.
          EXPECT_LT(std::abs(modal_receptance(system, m, f) / exact - 1.0), 1e-8)
              << n << ' ' << eta << ' ' << hi << ' ' << f;
          EXPECT_GT(system.relaxed_stiffness[m], 0.0);
        }
        EXPECT_LT(system.pole.real().maxCoeff(), 0.0) << n << ' ' << eta << ' ' << hi;
      }
    }
  }
}

TEST(PoleSystem, RestTakesTheLowestFrequencyAtWhichTheModulusIsKnown) {
  auto law = power_law(1e11, 0.1);
  EXPECT_EQ(rest_frequency_hz(law, 30.0), 30.0);
  law.valid_from_hz = 50.0;
  EXPECT_EQ(rest_frequency_hz(law, 30.0), 50.0);
  FrequencyLaw table;
  table.kind = FrequencyLaw::Kind::table;
  table.frequency = {2.0, 1000.0};
  table.value = {9e10, 1.1e11};
  EXPECT_EQ(rest_frequency_hz(table, 30.0), 2.0);
  Material material = strand(0.0, 0.1);
  material.youngs_modulus = table;
  const Modes body(material, {31.0, 86.0});
  for (const auto damping : {Damping::structural, Damping::viscous}) {
    const auto system = body.poles(damping);
    for (int m = 0; m < 2; ++m) {
      EXPECT_NEAR(system.rest_stiffness[m] / (body.modes.eigenvalue[m] * 9e10), 1.0, 1e-15);
    }
  }
}

TEST(MaxwellLaw, FitsACausalPairOfLawsClosely) {
  // (i w)^n: eta = tan(n pi/2) is what E ~ f^n demands.
  for (const double n : {0.02, 0.1}) {
    const auto modulus = power_law(1e11, n);
    const double eta = std::tan(0.5 * std::numbers::pi * n);
    const auto law = fit_maxwell_law(modulus, constant_law(eta), 5.0, 1500.0);
    for (double f = 5.0; f < 1500.0; f *= 1.1) {
      const Complex wanted = modulus.at(f) * Complex(1.0, eta);
      // Ripple of 1.5 relaxation times per decade, 1 % of the loss, and the end of their range.
      EXPECT_LT(std::abs(law.at(Complex(0.0, two_pi * f)) / wanted - 1.0), 0.012 * eta) << f;
    }
  }
}

TEST(MaxwellLaw, IsPassiveAndStaysSoWhenMadeExact) {
  const auto law = fit_maxwell_law(power_law(1e11, 0.02), constant_law(0.0374), 5.0, 1000.0);
  for (const double at : {5.0, 100.0, 20000.0}) {
    const auto exact = exact_at(law, 1e11, 0.03, at, 1000.0);
    const Complex value = exact.at(Complex(0.0, two_pi * at));
    EXPECT_NEAR(value.real(), 1e11, 1.0);     // rounding
    EXPECT_NEAR(value.imag(), 0.03e11, 1.0);  // rounding
    EXPECT_GT(exact.relaxed, 0.0);
    EXPECT_GE(exact.viscosity, 0.0);
    EXPECT_GE(exact.strength.minCoeff(), 0.0);
  }
}

TEST(MaxwellLaw, DerivativeIsThatOfTheLaw) {
  const auto law = fit_maxwell_law(power_law(1e11, 0.05), constant_law(0.08), 5.0, 1000.0);
  const Complex s(-3.0, 400.0);
  const double h = 1e-2;
  const Complex slope = (law.at(s + h) - law.at(s - h)) / (2.0 * h);
  EXPECT_LT(std::abs(slope / law.derivative(s) - 1.0), 1e-6);  // h^2 and rounding E eps/(h E')
}

TEST(MaxwellLaw, ElasticMaterialHasNoMemory) {
  const auto law = fit_maxwell_law(constant_law(1e11), constant_law(0.0), 5.0, 1000.0);
  EXPECT_NEAR(law.relaxed, 1e11, 1.0);
  EXPECT_EQ(law.strength.size(), 0);
  EXPECT_LT(law.viscosity, 1e-3);
}

TEST(MaxwellLaw, RefusesWhatItCannotDo) {
  const auto modulus = constant_law(1e11);
  EXPECT_THROW(fit_maxwell_law(modulus, modulus, 0.0, 100.0), Error);
  EXPECT_THROW(fit_maxwell_law(modulus, modulus, 100.0, 100.0), Error);
  EXPECT_THROW(fit_maxwell_law(modulus, modulus, 1.0, std::nan("")), Error);
  const auto law = fit_maxwell_law(power_law(1e11, 0.02), constant_law(0.03), 5.0, 1000.0);
  EXPECT_THROW(exact_at(law, 0.0, 0.03, 100.0, 1000.0), Error);
  EXPECT_THROW(exact_at(law, 1e11, -0.03, 100.0, 1000.0), Error);
  EXPECT_THROW(exact_at(law, 1e11, 0.03, 0.0, 1000.0), Error);
  EXPECT_THROW(exact_at(law, 1e11, std::nan(""), 100.0, 1000.0), Error);
}

}  // namespace
}  // namespace struna::fem
