// The stabilisation analysis from the command line: its file, its page, its columns in the modes file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ident/mode_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string modes_of_true_function(const std::string& options) {
  return "modes '" + sample_data("curved_wire/true_trfam.csv").string() + "' -o modes.csv --band 10:500" +
         options;
}

TEST(Stabilisation, IsWrittenAsAFileAndDrawnOnAPage) {
  const Folder folder;
  const ProgramRun run =
      run_struna(modes_of_true_function(" --stabilisation poles.csv --report modes.html"), folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(read_text(folder / "poles.csv"),
              StartsWith("order [-],natural_frequency [Hz],loss_factor [-],stability,column\n"));
  const std::string page = read_text(folder / "modes.html");
  EXPECT_THAT(page, HasSubstr("<section id=\"stabilisation\">"));
  EXPECT_THAT(page, HasSubstr("StabilisationChart.draw"));
  EXPECT_THAT(page, HasSubstr("\"stability\":["));
  const ident::ModeSet set = ident::read_modes((folder / "modes.csv").string());
  ASSERT_GT(set.modes.size(), 5u);
  for (const ident::Mode& mode : set.modes) EXPECT_GT(mode.orders, 0);
}

TEST(Stabilisation, IsRefusedWithMethodsThatDoNotAskIt) {
  const Folder folder;
  const ProgramRun run =
      run_struna(modes_of_true_function(" --method circle --stabilisation poles.csv"), folder);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--stabilisation: only with --method auto or multi, got circle"));
  EXPECT_FALSE(std::filesystem::exists(folder / "modes.csv"));
}

TEST(Stabilisation, DoesNotOverwriteTheModes) {
  const Folder folder;
  const ProgramRun run = run_struna(modes_of_true_function(" --stabilisation modes.csv"), folder);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder / "modes.csv"));
}

}  // namespace
}  // namespace struna::tests
