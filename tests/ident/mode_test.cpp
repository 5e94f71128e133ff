#include "ident/mode.hpp"

#include <gtest/gtest.h>

#include "fem/error.hpp"
#include "tests/ident/simulated_modes.hpp"

namespace struna::ident {
namespace {

TEST(Mode, FlagWordsGoBothWays) {
  for (const auto flag : {ModeFlag::coarse, ModeFlag::close_modes, ModeFlag::double_mode, ModeFlag::noisy,
                          ModeFlag::edge, ModeFlag::poor_circle, ModeFlag::not_converged})
    EXPECT_EQ(mode_flag(to_string(flag)), flag);
  EXPECT_EQ(to_string(ModeFlag::close_modes), "close_modes");
  EXPECT_THROW(mode_flag("closed"), Error);
}

TEST(Mode, CircleFormIsReceptanceOrApparentMass) {
  using fem::Damping;
  for (const auto kind : {FrfKind::receptance, FrfKind::mobility, FrfKind::accelerance}) {
    EXPECT_EQ(circle_form(kind, Damping::structural), FrfKind::receptance);
    EXPECT_EQ(circle_form(kind, Damping::viscous), FrfKind::mobility);
  }
  for (const auto kind : {FrfKind::dynamic_stiffness, FrfKind::impedance, FrfKind::apparent_mass}) {
    EXPECT_EQ(circle_form(kind, Damping::structural), FrfKind::apparent_mass);
    EXPECT_EQ(circle_form(kind, Damping::viscous), FrfKind::apparent_mass);
  }
  for (const auto kind : {FrfKind::transmissibility, FrfKind::unknown})
    EXPECT_EQ(circle_form(kind, Damping::structural), kind);
}

TEST(Mode, ToCircleFormDividesByMinusOmegaSquared) {
  TransferFunction tf;
  tf.frequency_hz = simulated::lines(10.0, 20.0, 5.0);
  TransferFunction::Output output;
  output.kind = FrfKind::dynamic_stiffness;
  output.unit = "N/m";
  output.value = Eigen::VectorXcd::Constant(3, std::complex(2.0, 1.0));
  tf.outputs.push_back(output);
  const TransferFunction form = to_circle_form(tf, fem::Damping::structural);
  EXPECT_EQ(form.outputs[0].kind, FrfKind::apparent_mass);
  for (long i = 0; i < 3; ++i) {
    const double omega = 2.0 * std::numbers::pi * tf.frequency_hz(i);
    EXPECT_NEAR(std::abs(form.outputs[0].value(i) * -omega * omega - std::complex(2.0, 1.0)), 0.0,
                1e-12);  // rounding
  }
}

}  // namespace
}  // namespace struna::ident
