// `struna limits`: files that it writes, faults that it tells.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(Limits, WritesTheTableThePageAndAPicturePerMap) {
  const Folder folder;
  const auto run = run_struna("limits --map rayleigh --seeds 2 -o out", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(read_text(folder / "out/limits.csv"), HasSubstr("\nrayleigh,modes [-],1,"));
  EXPECT_THAT(read_text(folder / "out/limits_rayleigh.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(read_text(folder / "out/index.html"),
              HasSubstr("struna limits --map rayleigh --seeds 2 -o out"));
  EXPECT_THAT(run.out, HasSubstr("rayleigh: Two coefficients cannot follow the damping"));
}

TEST(Limits, TellsFaultsInOneLineAndLeavesNothing) {
  const Folder folder;
  for (const std::string arguments :
       {"--map circles -o out", "--map circle --seeds 0 -o out", "--map circle"}) {
    const auto run = run_struna("limits " + arguments, folder);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_THAT(run.err, StartsWith("struna: ")) << arguments;
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << arguments;
  }
}

}  // namespace
}  // namespace struna::tests
