// Measured records and transfer functions, through the program, against what was published or seen of them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "ident/csv.hpp"
#include "ident/single_dof.hpp"
#include "ident/transfer_function_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

using ident::SingleDof;
using ident::StiffnessWeight;

/// A spring-mass-damper cart in nine settings: natural frequency and damping ratio as seen before. The data
/// may not be copied here: STRUNA_EXTRA_DATA names the folder that holds `cart`.
class Cart : public testing::Test {
 protected:
  void SetUp() override {
    const char* extra = std::getenv("STRUNA_EXTRA_DATA");
    if (!extra || !std::filesystem::exists(std::filesystem::path(extra) / "cart"))
      GTEST_SKIP() << "STRUNA_EXTRA_DATA does not name a folder with cart/";
    data_ = std::filesystem::absolute(std::filesystem::path(extra) / "cart");
  }

  /// The receptance of a setting, inverted.
  ident::TransferFunction from_receptance(int setting, double lo_hz, double hi_hz) const {
    const auto tf =
        ident::read_transfer_function((data_ / fmt::format("receptance_{}.csv", setting)).string());
    return ident::convert(ident::restrict_band(tf, lo_hz, hi_hz), ident::FrfKind::dynamic_stiffness);
  }

  /// The swept records of a setting, through the program.
  ident::TransferFunction from_sweep(int setting) const {
    const Folder folder;
    const ProgramRun run =
        run_struna(fmt::format("frf '{}/sweep_{}.csv' --input displacement --output force --form "
                               "dynamic-stiffness --band 1.5:8 -o out.csv",
                               data_.string(), setting),
                   folder);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return ident::read_transfer_function((folder / "out.csv").string());
  }

  std::filesystem::path data_;
};

struct Seen {
  int setting;
  double natural_frequency_hz;
  double damping_ratio;
};
// Setting 5 (damping ratio 0.65) has no resonance to speak of.
constexpr Seen seen[] = {{1, 5.586, 0.0243}, {2, 5.590, 0.0442}, {3, 5.604, 0.1643}, {4, 5.630, 0.2926},
                         {6, 5.275, 0.0518}, {7, 4.945, 0.0631}, {8, 3.283, 0.0502}, {9, 2.759, 0.0492}};

TEST_F(Cart, ReceptancesGiveTheSeenFrequencyAndDamping) {
  // The cart's friction is not viscous: what the band sees depends on it by up to 0.3 % and 1.7 %.
  for (const Seen& s : seen) {
    const SingleDof fit = ident::fit_single_dof_stiffness(from_receptance(s.setting, 1.5, 8.0));
    EXPECT_NEAR(fit.natural_frequency_hz / s.natural_frequency_hz, 1.0, 0.005) << s.setting;
    EXPECT_NEAR(fit.damping_ratio / s.damping_ratio, 1.0, 0.03) << s.setting;
  }
}

TEST_F(Cart, SweepsGiveTheSeenFrequencyAndDamping) {
  for (const Seen& s : seen) {
    if (s.setting != 2 && s.setting != 6 && s.setting != 7 && s.setting != 9) continue;
    const SingleDof fit = ident::fit_single_dof_stiffness(from_sweep(s.setting));
    EXPECT_NEAR(fit.natural_frequency_hz / s.natural_frequency_hz, 1.0, 0.005) << s.setting;
    EXPECT_NEAR(fit.damping_ratio / s.damping_ratio, 1.0, 0.03) << s.setting;
  }
}

/// Largest spread of the stiffnesses over their mean.
double spread(const std::vector<SingleDof>& fits) {
  double lowest = INFINITY, highest = 0.0, mean = 0.0;
  for (const SingleDof& fit : fits) {
    lowest = std::min(lowest, fit.stiffness);
    highest = std::max(highest, fit.stiffness);
    mean += fit.stiffness / static_cast<double>(fits.size());
  }
  return (highest - lowest) / mean;
}

// Settings 7, 8, 9 differ in mass alone. Near resonance the friction, which depends on amplitude, softens the
// spring, so the weight that trusts the quiet side of the band tells spring from mass.
TEST_F(Cart, ThreeMassesOnOneSpringAreToldApart) {
  std::vector<SingleDof> fits;
  for (const int setting : {7, 8, 9})
    fits.push_back(
        ident::fit_single_dof_stiffness(from_receptance(setting, 1.5, 8.0), StiffnessWeight::integrated));
  EXPECT_LT(spread(fits), 0.005);
  EXPECT_NEAR(fits[1].mass / fits[0].mass / 2.265, 1.0, 0.01);
  EXPECT_NEAR(fits[2].mass / fits[0].mass / 3.210, 1.0, 0.01);

  const std::vector<SingleDof> swept{
      ident::fit_single_dof_stiffness(from_sweep(7), StiffnessWeight::integrated),
      ident::fit_single_dof_stiffness(from_sweep(9), StiffnessWeight::integrated)};
  EXPECT_LT(spread(swept), 0.01);
  EXPECT_NEAR(swept[1].mass / swept[0].mass / 3.210, 1.0, 0.01);
}

TEST_F(Cart, AWiderBandGivesTheSeenValuesToTheirLastDigitAndOneSpring) {
  std::vector<SingleDof> fits;
  for (const Seen& s : seen) {
    const SingleDof fit = ident::fit_single_dof_stiffness(from_receptance(s.setting, 1.0, 10.0));
    EXPECT_NEAR(fit.natural_frequency_hz, s.natural_frequency_hz, 6e-4)
        << s.setting;  // half of the last digit shown
    EXPECT_NEAR(fit.damping_ratio, s.damping_ratio, 6e-5) << s.setting;
    if (s.setting >= 7) fits.push_back(fit);
  }
  EXPECT_LT(spread(fits), 0.002);
  EXPECT_NEAR(fits[0].stiffness, 810.0, 1.0);
}

TEST_F(Cart, ASweepIsTakenInOneSegmentWithoutAskingForIt) {
  const ident::TransferFunction tf = from_sweep(7);
  EXPECT_NEAR(tf.frequency_hz[1] - tf.frequency_hz[0], 0.025, 1e-9);  // 1/40 s
  EXPECT_EQ(tf.outputs[0].kind, ident::FrfKind::dynamic_stiffness);
  EXPECT_EQ(tf.outputs[0].coherence.size(), 0);
}

}  // namespace
}  // namespace struna::tests
