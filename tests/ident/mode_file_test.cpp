#include "ident/mode_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::ident {
namespace {

using tests::Folder;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

ModeSet two_modes(fem::Damping damping) {
  ModeSet set;
  set.damping = damping;
  set.form = circle_form(FrfKind::dynamic_stiffness, damping);
  set.outputs = {"force_x", "force_y"};
  set.units = {"kg", "kg"};
  Mode mode;
  mode.natural_frequency_hz = 16.80702469;
  mode.natural_frequency_sigma = 0.01030986468;
  mode.lower_half_power_hz = 16.43656302;
  mode.upper_half_power_hz = 17.16949487;
  mode.loss_factor = 0.04359829378;
  mode.loss_factor_sigma = 0.001228017305;
  mode.damping_ratio = 0.02179914689;
  mode.flags = {ModeFlag::coarse, ModeFlag::noisy};
  mode.circle_natural_frequency_hz = 16.81;
  mode.circle_loss_factor = 0.0437;
  mode.modal_constant = Eigen::Vector2cd(std::complex(1.25, -0.5), std::complex(-3e-7, 2e5));
  mode.modal_constant_sigma = Eigen::Vector2d(0.125, 3.0);
  set.modes.push_back(mode);
  mode.natural_frequency_hz = 22.9;
  mode.loss_factor_sigma = nan;  // a method without standard errors
  mode.natural_frequency_sigma = nan;
  mode.circle_natural_frequency_hz = nan;
  mode.circle_loss_factor = nan;
  mode.flags.clear();
  set.modes.push_back(mode);
  return set;
}

std::string write(const Folder& folder, const std::string& text) {
  const std::string file = (folder / "modes.csv").string();
  std::ofstream(file) << text;
  return file;
}

std::string message_of(const std::string& file) {
  try {
    read_modes(file);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(ModeFile, ReadsBackWhatItWrote) {
  const Folder folder;
  const std::string file = (folder / "modes.csv").string();
  for (const auto damping : {fem::Damping::structural, fem::Damping::viscous}) {
    const ModeSet written = two_modes(damping);
    write_modes(written, file);
    const ModeSet read = read_modes(file);
    EXPECT_EQ(read.damping, written.damping);
    EXPECT_EQ(read.form, written.form);
    EXPECT_EQ(read.outputs, written.outputs);
    EXPECT_EQ(read.units, written.units);
    ASSERT_EQ(read.modes.size(), 2u);
    for (std::size_t r = 0; r < 2; ++r) {
      // Ten digits are written: rounding of the last one.
      const auto same = [](double a, double b) {
        return std::isnan(a) ? std::isnan(b) : std::abs(a / b - 1) < 1e-9;
      };
      const Mode& a = written.modes[r];
      const Mode& b = read.modes[r];
      EXPECT_TRUE(same(a.natural_frequency_hz, b.natural_frequency_hz));
      EXPECT_TRUE(same(a.natural_frequency_sigma, b.natural_frequency_sigma));
      EXPECT_TRUE(same(a.lower_half_power_hz, b.lower_half_power_hz));
      EXPECT_TRUE(same(a.upper_half_power_hz, b.upper_half_power_hz));
      EXPECT_TRUE(same(a.loss_factor, b.loss_factor));
      EXPECT_TRUE(same(a.loss_factor_sigma, b.loss_factor_sigma));
      EXPECT_TRUE(same(a.damping_ratio, b.damping_ratio));
      EXPECT_TRUE(same(a.circle_natural_frequency_hz, b.circle_natural_frequency_hz));
      EXPECT_TRUE(same(a.circle_loss_factor, b.circle_loss_factor));
      EXPECT_EQ(a.flags, b.flags);
      EXPECT_TRUE(a.modal_constant.isApprox(b.modal_constant, 1e-9));
      EXPECT_TRUE(a.modal_constant_sigma.isApprox(b.modal_constant_sigma, 1e-9));
    }
  }
}

TEST(ModeFile, HeaderStartsAsScriptsRelyOn) {
  const Folder folder;
  const std::string file = (folder / "modes.csv").string();
  write_modes(two_modes(fem::Damping::structural), file);
  std::string header;
  std::ifstream stream(file);
  std::getline(stream, header);
  EXPECT_EQ(
      header,
      "mode,natural_frequency [Hz],natural_frequency_sigma [Hz],lower_half_power [Hz],upper_half_power [Hz],"
      "loss_factor [-],loss_factor_sigma [-],damping_ratio [-],flags,circle_natural_frequency [Hz],"
      "circle_loss_factor [-],force_x_constant_re [kg/s^2],force_x_constant_im [kg/s^2],"
      "force_x_constant_sigma [kg/s^2],force_y_constant_re [kg/s^2],force_y_constant_im [kg/s^2],"
      "force_y_constant_sigma [kg/s^2]");
}

TEST(ModeFile, ReadsHandMadeTables) {
  const Folder folder;
  const ModeSet set =
      read_modes(write(folder, "natural_frequency [Hz],damping_ratio [-]\n20,0.01\n60,0.02\n"));
  ASSERT_EQ(set.modes.size(), 2u);
  EXPECT_TRUE(set.outputs.empty());
  EXPECT_DOUBLE_EQ(set.modes[1].loss_factor, 0.04);
  EXPECT_TRUE(std::isnan(set.modes[1].loss_factor_sigma));
  EXPECT_NEAR(set.modes[0].upper_half_power_hz, 20.0 * std::sqrt(1.02), 1e-12);  // eq. (13), rounding
}

TEST(ModeFile, RefusesWhatItWouldMisread) {
  const struct {
    const char* text;
    const char* message;
  } cases[] = {
      {"natural_frequency [kHz],loss_factor [-]\n0.02,0.01\n", "must be Hz"},
      {"natural_frequency [Hz],loss_factor [%]\n20,1\n", "must be -"},
      {"natural_frequency [Hz]\n20\n", ":2: needs a loss_factor or a damping_ratio"},
      {"natural_frequency [Hz],loss_factor [-]\n-20,0.01\n", ":2: natural_frequency is -20 Hz"},
      {"natural_frequency [Hz],loss_factor [-]\n20,0\n", ":2: loss_factor is 0"},
      {"natural_frequency [Hz],loss_factor [-]\n60,0.01\n20,0.01\n", ":3: natural frequencies must not fall"},
      {"natural_frequency [Hz],loss_factor [-],flags\n20,0.01,nosiy\n", ":2: "},
      {"natural_frequency [Hz],loss_factor [-]\n", "has no modes"},
      {"frequency [Hz],loss_factor [-]\n20,0.01\n", "natural_frequency"},
      {"natural_frequency [Hz],loss_factor [-],y_constant_re [kg],y_constant_im [kg]\n20,0.01,1,0\n",
       "must end in /s^2"},
  };
  const Folder folder;
  for (const auto& refused : cases) {
    const std::string message = message_of(write(folder, refused.text));
    EXPECT_NE(message.find(refused.message), std::string::npos) << refused.text << "said: " << message;
    EXPECT_EQ(message.find((folder / "modes.csv").string()), 0u) << message;
  }
}

}  // namespace
}  // namespace struna::ident
