// Pairs of measured and model modes with modes missing, modes that are none, and another modulus.
#include "apps/limit_pairing.hpp"

#include <gtest/gtest.h>

namespace struna::apps {
namespace {

TEST(Limits, PairsAreTrueWhereNoModeIsMissingWhateverIsSpuriousAndTheScenesModulus) {
  LimitRun run;
  run.seeds = 1;
  run.every = 2;
  const LimitMap map = pairing_limits(run);
  LimitMap sound = map;
  std::erase_if(sound.trials, [](const LimitTrial& t) { return t.at[0] > 20.0; });
  EXPECT_EQ(count_of(sound).wrong, 0);
  EXPECT_EQ(count_of(sound).right, 6);  // three numbers of spurious modes, two moduli
  const LimitCount at_low = count_at(map, {0.0, 0.0, map.axes[2].values.front()});
  EXPECT_EQ(at_low.right, 1);
}

}  // namespace
}  // namespace struna::apps
