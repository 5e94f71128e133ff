// The paper's findings on contact, with runs shorter than those of docs/studies.md.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "ident/record.hpp"
#include "ident/record_comparison.hpp"
#include "ident/spectra.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

/// Force spectrum of a sample scene, simulated with another duration and band.
class StudyRun {
 public:
  StudyRun(const std::string& scene, const std::string& output, double duration, const std::string& band) {
    const Folder folder;
    std::string text = read_text(sample_data(scene));
    const auto line = text.find("duration = ");
    text.replace(line, text.find('\n', line) - line, "duration = " + std::to_string(duration));
    folder.write("scene.toml", replaced(text, "band = [10, 1000]", "band = " + band));
    const auto run = run_struna("simulate scene.toml -o out.csv", folder);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const auto record = ident::read_record((folder / "out.csv").string(), {"displacement", output});
    ident::WelchOptions options;
    options.window = ident::Window::hann;
    spectra_ = ident::welch_spectra(record, "displacement", {output}, options);
  }

  /// Force in a band [N rms].
  double force(double lo, double hi) const {
    Eigen::VectorXd edge(2);
    edge << lo, hi;
    return ident::half_octave_levels(spectra_.frequency_hz, spectra_.output_auto.col(0), edge).rms[0];
  }

 private:
  ident::Spectra spectra_;
};

// Run B. One second from 40 to 450 Hz passes the first four natural frequencies of the wire.
const char* const sweep = "[40, 450]";
StudyRun filter(const std::string& scene) {
  return StudyRun("paper_filter/" + scene, "force_y", 1.0, sweep);
}

TEST(PaperFilter, SmallGapTakesThePeaksOut) {
  const StudyRun none = filter("none.toml"), wide = filter("case_1.toml"), narrow = filter("case_2.toml");
  // The second to the fourth natural frequency, each with its flanks.
  EXPECT_LT(narrow.force(70.0, 110.0), 0.25 * none.force(70.0, 110.0));
  EXPECT_LT(narrow.force(150.0, 200.0), 0.35 * none.force(150.0, 200.0));
  EXPECT_LT(narrow.force(260.0, 310.0), 0.6 * none.force(260.0, 310.0));
  // Through the wide gap the wire moves as without a band once its motion is smaller than the gap.
  EXPECT_GT(wide.force(260.0, 310.0), 0.8 * none.force(260.0, 310.0));
  EXPECT_LT(narrow.force(70.0, 110.0), 0.3 * wide.force(70.0, 110.0));
}

TEST(PaperFilter, ContactFeedsFrequenciesAboveTheExcitation) {
  const StudyRun none = filter("none.toml"), narrow = filter("case_2.toml");
  EXPECT_GT(narrow.force(1050.0, 4000.0), 100.0 * none.force(1050.0, 4000.0));
}

TEST(PaperFilter, ModulusOfTheBandHardlyMatters) {
  // Trajectories part: over one second the level of a band of an octave differs by up to a quarter between
  // runs that differ in their last digits.
  const StudyRun soft = filter("case_2.toml"), stiff = filter("case_4.toml");
  for (const auto& [lo, hi] : {std::pair{40.0, 80.0}, std::pair{80.0, 160.0}, std::pair{160.0, 320.0}}) {
    EXPECT_NEAR(stiff.force(lo, hi) / soft.force(lo, hi), 1.0, 0.35) << lo;
  }
}

// Run A. The same motion in all three: half a second of the same seed.
TEST(PaperGap, SmallGapTakesLowPeaksOutAndFeedsHighFrequenciesMore) {
  const auto gap = [](const std::string& scene) {
    return StudyRun("paper_gap/" + scene, "force_z", 0.5, "[10, 1000]");
  };
  const StudyRun none = gap("no_band.toml"), small = gap("small_gap.toml"), large = gap("large_gap.toml");
  EXPECT_LT(small.force(20.0, 57.0), 0.9 * none.force(20.0, 57.0));
  EXPECT_LT(small.force(20.0, 57.0), large.force(20.0, 57.0));
  EXPECT_GT(small.force(1050.0, 4000.0), 2.0 * large.force(1050.0, 4000.0));
  // What is there without a band is the window's leakage, larger for a short record.
  EXPECT_GT(large.force(1050.0, 4000.0), 30.0 * none.force(1050.0, 4000.0));
}

}  // namespace
}  // namespace struna::tests
