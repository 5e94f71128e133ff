// Pairs of measured and model modes with modes missing, modes that are none, and another modulus.
#include "apps/limit_pairing.hpp"

#include <gtest/gtest.h>

namespace struna::apps {
namespace {

const LimitMap& coarse_map() {
  static const LimitMap map = [] {
    LimitRun run;
    run.seeds = 1;
    run.every = 2;
    return pairing_limits(run);
  }();
  return map;
}

LimitMap of(LimitMap map, double least_missing, double most_missing) {
  std::erase_if(map.trials,
                [&](const LimitTrial& t) { return t.at[0] < least_missing || t.at[0] > most_missing; });
  return map;
}

TEST(Limits, PairsAreTrueAndUnflaggedWhileEnoughModesAreMeasured) {
  const LimitCount few_missing = count_of(of(coarse_map(), 0.0, 40.0));
  EXPECT_EQ(few_missing.wrong, 0);
  EXPECT_EQ(few_missing.right_flagged, 0);
  EXPECT_EQ(few_missing.refused, 0);
  // None and three tenths missing; three numbers of spurious modes; two moduli: a dozen lists of a dozen.
  EXPECT_GE(few_missing.right, 12 * 9);
}

TEST(Limits, FalsePairsOfShortListsAreTold) {
  const LimitMap& map = coarse_map();
  const LimitCount short_lists = count_of(of(map, 85.0, 85.0));
  EXPECT_GT(short_lists.wrong, 0);
  EXPECT_EQ(short_lists.wrong_flagged, short_lists.wrong);
  // Whatever modulus the scene states: it takes no part.
  for (std::size_t i = 0; i < map.trials.size() / 2; ++i)
    EXPECT_EQ(map.trials[i].error, map.trials[i + map.trials.size() / 2].error) << i;
}

}  // namespace
}  // namespace struna::apps
