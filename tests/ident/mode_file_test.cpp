#include "ident/mode_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "fem/error.hpp"
#include "ident/mode_identification.hpp"
#include "simulated_modes.hpp"

namespace struna::ident {
namespace {

class ModeFile : public testing::Test {
 protected:
  std::string path = (std::filesystem::path(testing::TempDir()) / "mode_file_test.csv").string();
  void TearDown() override { std::filesystem::remove(path); }
  void write(const std::string& text) const { std::ofstream(path) << text; }
  std::string first_line() const {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
  }
};

TEST_F(ModeFile, RoundTripKeepsTenDigits) {
  for (const fem::Damping damping : {fem::Damping::structural, fem::Damping::viscous}) {
    ModeOptions options;
    options.damping = damping;
    ModeSet set = identify_modes(simulated::eight_mode_set(0.01, 1), options);
    ASSERT_GT(set.modes.size(), 2u);
    set.modes[1].flags = {ModeFlag::coarse, ModeFlag::close_modes};
    set.modes[2].circle_loss_factor = set.modes[2].resolves_from = std::nan("");
    write_modes(set, path);
    const ModeSet back = read_modes(path);
    EXPECT_EQ(back.damping, damping);
    EXPECT_EQ(back.form, set.form);
    EXPECT_EQ(back.outputs, set.outputs);
    ASSERT_EQ(back.modes.size(), set.modes.size());
    for (std::size_t r = 0; r < set.modes.size(); ++r) {
      const Mode &a = set.modes[r], &b = back.modes[r];
      EXPECT_NEAR(b.natural_frequency_hz / a.natural_frequency_hz, 1.0, 1e-9);
      EXPECT_NEAR(b.natural_frequency_sigma / a.natural_frequency_sigma, 1.0, 1e-9);
      EXPECT_NEAR(b.lower_half_power_hz / a.lower_half_power_hz, 1.0, 1e-9);
      EXPECT_NEAR(b.upper_half_power_hz / a.upper_half_power_hz, 1.0, 1e-9);
      EXPECT_NEAR(b.loss_factor / a.loss_factor, 1.0, 1e-9);
      EXPECT_NEAR(b.loss_factor_sigma / a.loss_factor_sigma, 1.0, 1e-9);
      EXPECT_NEAR(b.damping_ratio / a.damping_ratio, 1.0, 1e-9);
      EXPECT_EQ(b.flags, a.flags);
      EXPECT_EQ(std::isnan(b.resolves_from), r == 2);
      if (r != 2) {
        EXPECT_NEAR(b.resolves_from / a.resolves_from, 1.0, 1e-9);
      }
      EXPECT_EQ(b.stable_orders, a.stable_orders);
      EXPECT_EQ(b.orders, a.orders);
      EXPECT_GE(b.orders, 10);
      EXPECT_EQ(std::isnan(b.circle_loss_factor), std::isnan(a.circle_loss_factor));
      for (long k = 0; k < 3; ++k) {
        EXPECT_NEAR(std::abs(b.modal_constant(k) / a.modal_constant(k) - 1.0), 0.0, 1e-9);
        EXPECT_NEAR(b.modal_constant_sigma(k) / a.modal_constant_sigma(k), 1.0, 1e-9);
      }
    }
  }
}

TEST_F(ModeFile, ColumnsAreInTheOrderThatScriptsRelyOn) {
  write_modes(identify_modes(simulated::eight_mode_set(0.01, 1)), path);
  EXPECT_EQ(
      first_line().find(
          "mode,natural_frequency [Hz],natural_frequency_sigma [Hz],lower_half_power [Hz],"
          "upper_half_power [Hz],loss_factor [-],loss_factor_sigma [-],damping_ratio [-],flags,"
          "circle_natural_frequency [Hz],circle_loss_factor [-],"
          "force_x_constant_re [m/N/s^2],force_x_constant_im [m/N/s^2],force_x_constant_sigma [m/N/s^2]"),
      0u);
}

TEST_F(ModeFile, HandMadeTableOfFrequencyAndDampingIsEnough) {
  write("natural_frequency [Hz],damping_ratio [-]\n10,0.01\n20,0.02\n");
  const ModeSet set = read_modes(path);
  ASSERT_EQ(set.modes.size(), 2u);
  EXPECT_DOUBLE_EQ(set.modes[1].loss_factor, 0.04);
  EXPECT_TRUE(std::isnan(set.modes[1].natural_frequency_sigma));
  EXPECT_TRUE(set.outputs.empty());
}

TEST_F(ModeFile, FaultsAreToldWithFileAndLine) {
  const std::pair<const char*, const char*> faults[] = {
      {"frequency [Hz],loss_factor [-]\n10,0.01\n", "natural_frequency"},
      {"natural_frequency [Hz],loss_factor [-]\n", "no modes"},
      {"natural_frequency [Hz],loss_factor [-]\n10,0.01\nx,0.01\n", ":3"},
      {"natural_frequency [Hz],loss_factor [-]\n-10,0.01\n", ":2"},
      {"natural_frequency [Hz],loss_factor [-]\n10,0\n", ":2"},
      {"natural_frequency [Hz],loss_factor [-]\n20,0.01\n10,0.01\n", ":3"},
      {"natural_frequency [Hz]\n20\n", ":2"},
      {"natural_frequency [Hz],loss_factor [-],flags\n20,0.01,fine\n", ":2"},
      {"natural_frequency [Hz],loss_factor [-],orders [-]\n20,0.01,1.5\n", ":2"},
      {"natural_frequency [Hz],loss_factor [-],f_constant_re [kg],f_constant_im [kg]\n20,0.01,1,1\n", ":1"}};
  for (const auto& [text, told] : faults) {
    write(text);
    try {
      read_modes(path);
      ADD_FAILURE() << "read: " << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(told), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find(path), 0u) << error.what();
    }
  }
}

}  // namespace
}  // namespace struna::ident
