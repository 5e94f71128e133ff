#include <gtest/gtest.h>

#include "simulated_doublet.hpp"

namespace struna::ident::simulated {
namespace {

// The chart of tests/bench/doublet_bench.cpp on a coarser grid.
TEST(Doublet, IsResolvedWithinTheErrorBarsOrFlaggedWhereTheDataCanTell) {
  constexpr unsigned seeds = 3;
  for (const int outputs : {1, 3})
    for (const double noise : {0.001, 0.01, 0.05})
      for (const double spacing : {0.2, 0.3, 0.5, 1.0, 2.0, 5.0}) {
        const Doublet doublet{spacing, outputs, noise};
        const Verdicts verdicts = doublet_verdicts(doublet, seeds);
        if (can_be_told(doublet)) {
          EXPECT_EQ(verdicts.wrong, 0u) << outputs << " outputs, noise " << noise << ", spacing " << spacing;
        }
        if (spacing >= 1.5 || (outputs == 3 && noise <= 0.01)) {
          EXPECT_EQ(verdicts.resolved, seeds)
              << outputs << " outputs, noise " << noise << ", spacing " << spacing;
        }
      }
}

TEST(Doublet, CannotBeToldOnlyWhereOneOutputIsDrownedInNoise) {
  EXPECT_FALSE(can_be_told({0.2, 1, 0.05}));
  EXPECT_TRUE(can_be_told({0.2, 1, 0.01}));
  EXPECT_TRUE(can_be_told({0.2, 3, 0.05}));
}

TEST(Doublet, SingleModeIsHardlyEverTakenForOne) {
  TransferFunction clean = function_of({modes_of({})[0]}, lines(80.0, 130.0, 0.1), FrfKind::receptance);
  unsigned flagged = 0;
  constexpr unsigned seeds = 200;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    TransferFunction tf = clean;
    add_noise(tf, {0.01, 0.01, 0.01}, seed);
    const ModeSet set = identify_modes(tf);
    ASSERT_EQ(set.modes.size(), 1u) << "seed " << seed;
    flagged += set.modes[0].flags.empty() ? 0 : 1;
  }
  EXPECT_LE(flagged, 1u);  // one in ten thousand
}

}  // namespace
}  // namespace struna::ident::simulated
