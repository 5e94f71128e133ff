#include "fem/closed_forms.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;

ClampedBeam beam() {
  const Section section = solid_circle(0.0032);
  return {testing::wire_length, testing::wire_modulus * section.second_moment, 7650.0 * section.area};
}

void expect_close(Complex value, Complex reference, double tolerance) {
  EXPECT_LT(std::abs(value - reference), tolerance * std::abs(reference)) << value << " for " << reference;
}

TEST(ClosedForms, RootsMeetTheirPublishedDigits) {
  // 40-digit roots, rounded to double.
  const double roots[] = {4.730040744862704026024, 7.853204624095837556477, 10.99560783800167090667,
                          14.13716549125746417711, 17.27875965739948143809, 20.42035224562606109094,
                          23.56194490204045507539, 26.70353755550818624842, 29.84513020910325426700,
                          32.98672286269281956155, 36.12831551628262265035, 39.26990816987241546315};
  for (int mode = 1; mode <= 12; ++mode) EXPECT_DOUBLE_EQ(clamped_clamped_root(mode), roots[mode - 1]);
  EXPECT_DOUBLE_EQ(clamped_clamped_root(1000), 1000.5 * std::numbers::pi);
  EXPECT_THROW(clamped_clamped_root(0), Error);
}

TEST(ClosedForms, NaturalFrequenciesMeetTheReference) {
  const double reference[] = {24.39955817559, 67.25832166724, 131.85320264744, 217.96004180261,
                              325.59469949389};
  for (int mode = 1; mode <= 5; ++mode) {
    EXPECT_NEAR(natural_frequency_hz(beam(), mode), reference[mode - 1],
                6e-12 * reference[mode - 1]);  // digits given
  }
}

struct Line {
  double f_hz;
  Complex far;
  Complex near;
  Complex both;
};

// Independently computed, 14 digits, loss factor 0.02.
const Line lines[] = {
    {10,
     {-50.343103939752, -0.3376342140786},
     {-43.810578809283, 0.6155012511382},
     {-188.30736549807, 0.5557340741192}},
    {24.4,
     {-125.91769877922, 8484.8988987183},
     {-337.50266828034, 8486.2990068822},
     {-926.84073411911, 33942.395811201}},
    {50,
     {692.22803519101, -8.9499165345468},
     {-935.24159824632, 21.781292225441},
     {-486.02712611061, 25.662751381788}},
    {100,
     {-1742.2808848704, 3.9191717175361},
     {-1985.8193183876, 74.471555702482},
     {-7456.2004065161, 156.78145484004}},
    {131.85,
     {-946.56148726011, 47468.213034397},
     {-3557.3919294473, 47526.916255542},
     {-9007.9068334149, 189990.25857988}},
    {500,
     {-22810.376464978, -1709.6386711899},
     {-6858.1501518896, 2892.157310572},
     {-59337.053233735, 2365.0372787641}},
    {1000,
     {115817.13101574, 38159.321296118},
     {49289.064276057, 42146.808198916},
     {330212.39058359, 160612.25899007}},
};

TEST(ClosedForms, SupportStiffnessesMeetTheReference) {
  for (const Line& line : lines) {
    const double tolerance = 1e-11;  // digits given, times the steepness at the resonances
    expect_close(far_support_stiffness(beam(), 0.02, line.f_hz), line.far, tolerance);
    expect_close(shaken_support_stiffness(beam(), 0.02, line.f_hz), line.near, tolerance);
    expect_close(both_supports_stiffness(beam(), Complex(1.0, 0.02), 1.0, line.f_hz), line.both, tolerance);
  }
}

TEST(ClosedForms, RayleighDampingActsOnAbsoluteVelocity) {
  const std::pair<double, Complex> reference[] = {{10, {-188.30118041024, 5.1682006281241}},
                                                  {100, {-7462.2751289785, 61.237821726596}},
                                                  {1000, {267957.34311859, 221079.1846206}}};
  for (const auto& [f_hz, value] : reference) {
    const double omega = 2.0 * std::numbers::pi * f_hz;
    expect_close(
        both_supports_stiffness(beam(), Complex(1.0, 5e-6 * omega), Complex(1.0, -1.5 / omega), f_hz), value,
        1e-11);
  }
}

TEST(ClosedForms, StaticLimitIsTwelveEIOverLengthCubed) {
  const ClampedBeam b = beam();
  const double spring = 12.0 * b.bending_stiffness / std::pow(b.length, 3);
  EXPECT_NEAR(spring, 23.5724957423, 1e-9);
  for (const double f_hz : {1e-6, 1e-3}) {                             // deep in the series at small argument
    expect_close(far_support_stiffness(b, 0.0, f_hz), -spring, 1e-7);  // inertia: x^4/30
    expect_close(shaken_support_stiffness(b, 0.0, f_hz), spring, 1e-6);
  }
}

TEST(ClosedForms, SeriesAndDirectFormMeet) {
  // Either side of the change of formula at |x| = 1: a smooth function moves by its slope only.
  const ClampedBeam b = beam();
  const double f_hz = natural_frequency_hz(b, 1) / std::pow(clamped_clamped_root(1), 2);
  const Complex below = far_support_stiffness(b, 0.0, f_hz * (1.0 - 1e-10));
  const Complex above = far_support_stiffness(b, 0.0, f_hz * (1.0 + 1e-10));
  expect_close(below, above, 1e-11);
}

TEST(ClosedForms, ForcesAreMomentumOfTheWholeBeam) {
  // Both supports shaken is, by linearity and symmetry, twice the sum of near and far.
  for (const double f_hz : {3.0, 77.0, 640.0}) {
    expect_close(
        2.0 * (far_support_stiffness(beam(), 0.02, f_hz) + shaken_support_stiffness(beam(), 0.02, f_hz)),
        both_supports_stiffness(beam(), Complex(1.0, 0.02), 1.0, f_hz), 1e-12);
  }
}

TEST(ClosedForms, LongBeamsDoNotOverflow) {
  ClampedBeam b = beam();
  b.length = 100.0;  // x = b L near 4400 at 1 kHz: cosh x overflows at 711
  const Complex far = far_support_stiffness(b, 0.02, 1000.0);
  const Complex near = shaken_support_stiffness(b, 0.02, 1000.0);
  EXPECT_TRUE(std::isfinite(std::abs(far)) && std::isfinite(std::abs(near)));
  // The far end of a long damped beam feels nothing; the near one is half infinite: E I b^3 (1 + i)... with
  // tan x -> -i for Im x -> -inf: near = -E I b^3 (1 + tan x) = -E I b^3 (1 - i).
  const double omega = 2.0 * std::numbers::pi * 1000.0;
  const Complex modulus(1.0, 0.02);
  const Complex wave = std::pow(b.mass_per_length * omega * omega / (b.bending_stiffness * modulus), 0.25);
  expect_close(near, -b.bending_stiffness * modulus * wave * wave * wave * Complex(1.0, -1.0), 1e-9);
  EXPECT_LT(std::abs(far), 1e-6 * std::abs(near));
  EXPECT_THROW(far_support_stiffness(b, 0.02, 0.0), Error);
}

}  // namespace
}  // namespace struna::fem
