#include <gtest/gtest.h>

#include "simulated_doublet.hpp"

namespace struna::ident::simulated {
namespace {

// The chart of tests/bench/doublet_bench.cpp on a coarser grid.
TEST(Doublet, IsResolvedWithinTheErrorBarsOrFlagged) {
  constexpr unsigned seeds = 3;
  for (const int outputs : {1, 3})
    for (const double noise : {0.001, 0.01, 0.05})
      for (const double spacing : {0.2, 0.3, 0.5, 1.0, 2.0, 5.0}) {
        const Verdicts verdicts = doublet_verdicts({spacing, outputs, noise}, seeds);
        EXPECT_EQ(verdicts.wrong, 0u) << outputs << " outputs, noise " << noise << ", spacing " << spacing;
        if (spacing >= 1.5 || (outputs == 3 && noise <= 0.01)) {
          EXPECT_EQ(verdicts.resolved, seeds)
              << outputs << " outputs, noise " << noise << ", spacing " << spacing;
        }
      }
}

TEST(Doublet, SingleModeIsHardlyEverTakenForOne) {
  TransferFunction clean = function_of({modes_of({})[0]}, lines(80.0, 130.0, 0.1), FrfKind::receptance);
  unsigned doubles = 0, warned = 0;
  constexpr unsigned seeds = 200;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    TransferFunction tf = clean;
    add_noise(tf, {0.01, 0.01, 0.01}, seed);
    const ModeSet set = identify_modes(tf);
    ASSERT_EQ(set.modes.size(), 1u) << "seed " << seed;
    doubles += set.modes[0].has(ModeFlag::double_mode) ? 1 : 0;
    warned += set.modes[0].has(ModeFlag::may_be_two) ? 1 : 0;
  }
  EXPECT_LE(doubles, 1u);  // one in a thousand
  EXPECT_LE(warned, 19u);  // ten, the hints of one chance in 20, and three times their scatter
}

}  // namespace
}  // namespace struna::ident::simulated
