// Measured data with published results: from raw files to modes, one command line each.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "ident/csv.hpp"
#include "ident/mode_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

struct Published {
  double frequency_hz;
  double damping_ratio;
};

const ident::Mode* nearest(const ident::ModeSet& set, double f_hz) {
  const ident::Mode* best = nullptr;
  for (const ident::Mode& mode : set.modes) {
    const double distance = std::abs(mode.natural_frequency_hz - f_hz);
    if (!best || distance < std::abs(best->natural_frequency_hz - f_hz)) best = &mode;
  }
  return best;
}

ident::ModeSet modes_of_hit(const Folder& folder, const std::string& hit, const std::string& options) {
  const auto frf = run_struna("frf '" + sample_data("ladisk_beam/" + hit).string() +
                                  "' --input force --output acceleration --impact -o trfam.csv",
                              folder);
  EXPECT_EQ(frf.exit_code, 0) << frf.err;
  const auto modes = run_struna("modes trfam.csv -o modes.csv" + options, folder);
  EXPECT_EQ(modes.exit_code, 0) << modes.err;
  return ident::read_modes((folder / "modes.csv").string());
}

// Published for hit 1 by another program and method (LSCF); 5 % in the damping is how far methods and hits
// lie apart.
using Hit = std::pair<std::string, std::string>;  // file, options of `struna modes`
class HammerHit : public testing::TestWithParam<Hit> {};

TEST_P(HammerHit, MeetsThePublishedModes) {
  const Folder folder;
  const ident::ModeSet set = modes_of_hit(folder, GetParam().first, GetParam().second);
  for (const Published& published : {Published{695.0, 0.0047}, Published{1897.5, 0.0031},
                                     Published{2777.3, 0.0024}, Published{3671.2, 0.0020}}) {
    const ident::Mode* mode = nearest(set, published.frequency_hz);
    ASSERT_NE(mode, nullptr);
    EXPECT_NEAR(mode->natural_frequency_hz / published.frequency_hz, 1.0, 1.5e-3);
    EXPECT_NEAR(mode->damping_ratio / published.damping_ratio, 1.0, 0.05) << published.frequency_hz << " Hz";
  }
}

INSTANTIATE_TEST_SUITE_P(Ladisk, HammerHit,
                         testing::Values(Hit{"hit_1.csv", ""}, Hit{"hit_1.csv", " --band 500:4000"},
                                         Hit{"hit_2.csv", " --band 500:4000"}));

TEST(HammerHits, AgreeAndWhatExceedsTheirErrorsIsToldAsVariation) {
  const Folder folder;
  for (const std::string hit : {"hit_1", "hit_2"}) {
    modes_of_hit(folder, hit + ".csv", " --band 500:4000");
    std::filesystem::rename(folder / "modes.csv", folder / (hit + ".csv"));
  }
  const auto run = run_struna("variation hit_1.csv hit_2.csv -o variation.csv", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ident::CsvReader csv((folder / "variation.csv").string());
  std::vector<std::string_view> fields;
  int published = 0, varying = 0;
  while (csv.next(fields)) {
    const auto value = [&](const char* name) { return csv.number(fields, csv.column(name)); };
    const double f = value("natural_frequency");
    for (const double known : {695.0, 1897.5, 2777.3, 3671.2}) {
      if (std::abs(f / known - 1.0) > 2e-3 || value("sets") < 2.0) continue;
      ++published;
      EXPECT_LT(value("natural_frequency_largest") / f, 2e-4) << f;
      EXPECT_LT(value("loss_factor_largest") / value("loss_factor"), 0.06) << f;
      const bool varies =
          value("natural_frequency_probability") < 0.05 || value("loss_factor_probability") < 0.05;
      varying += varies ? 1 : 0;
    }
  }
  EXPECT_EQ(published, 4);
  // The hits differ by more than their noise: the beam was struck at slightly other places and strengths.
  EXPECT_GT(varying, 0);
  EXPECT_NE(run.out.find("vary by more than their standard errors explain"), std::string::npos);
}

// Published circle fit of one analyser function with one line per half-power band.
TEST(AnalyserFunction, MeetsThePublishedCircleFit) {
  const Folder folder;
  const auto run = run_struna("modes '" + sample_data("slater/case1_frf.csv").string() +
                                  "' --band 156.25:312.5 --method circle -o modes.csv",
                              folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("chan2/chan1"), std::string::npos) << "no warning of the unknown unit";
  const ident::ModeSet set = ident::read_modes((folder / "modes.csv").string());
  ASSERT_EQ(set.modes.size(), 1u);
  EXPECT_NEAR(set.modes[0].natural_frequency_hz / 212.092530551, 1.0, 1e-5);
  EXPECT_NEAR(set.modes[0].damping_ratio, 0.000865, 0.02 * 0.000865);
  EXPECT_TRUE(set.modes[0].has(ident::ModeFlag::coarse));
}

}  // namespace
}  // namespace struna::tests
