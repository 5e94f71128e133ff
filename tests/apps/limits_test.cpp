// Maps of where methods stop working: how results are judged, and small maps with both sides of each border.
#include "apps/limits.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/limit_contact.hpp"
#include "apps/limit_damping.hpp"
#include "apps/limit_laws.hpp"
#include "apps/limit_modes.hpp"
#include "apps/limit_newmark.hpp"
#include "apps/limit_page.hpp"
#include "apps/limit_penalty.hpp"
#include "apps/limit_stepping.hpp"
#include "apps/limit_svg.hpp"
#include "apps/limit_transfer.hpp"

namespace struna::apps {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

LimitTrial trial(double error, double sigma, double tolerance, const std::string& flags = "",
                 bool refused = false) {
  return {{1.0, 2.0}, 1, error, sigma, tolerance, refused, flags};
}

LimitMap small_map() {
  LimitMap map;
  map.name = "small";
  map.title = "A & B";
  map.quantity = "length (relative)";
  map.axes = {{"x [m]", {1.0, 3.0}}, {"y [s]", {2.0}}};
  map.fails = "it bends";
  map.sign = "a crack";
  map.then = "stops";
  map.trials = {trial(0.0, 1.0, 0.0),           trial(0.5, 1.0, 1.0, "noisy"),
                trial(9.0, 1.0, 0.0),           trial(9.0, 1.0, 0.0, "coarse"),
                trial(nan, 1.0, 0.0, "coarse"), trial(0.0, nan, 0.1, "", true),
                trial(2.0, 1.0, 0.5, "noisy")};
  return map;
}

/// The trials of a map that `wanted` picks.
template <class Wanted>
LimitMap part_of(LimitMap map, Wanted wanted) {
  std::erase_if(map.trials, [&](const LimitTrial& t) { return !wanted(t); });
  return map;
}

TEST(LimitMap, WrongIsBeyondFiveSigmasOrBeyondThreeAndTheTolerance) {
  struct Case {
    double error, sigma, tolerance;
    Outcome expected;
  };
  for (const auto& c : {Case{2.9, 1.0, 0.0, Outcome::uncertain}, Case{3.1, 1.0, 4.0, Outcome::right},
                        Case{3.1, 1.0, 3.0, Outcome::wrong}, Case{4.9, 1.0, 9.0, Outcome::right},
                        Case{5.1, 1.0, 9.0, Outcome::wrong}, Case{0.09, nan, 0.1, Outcome::right},
                        Case{0.11, nan, 0.1, Outcome::wrong}, Case{nan, 1.0, 9.0, Outcome::wrong}}) {
    EXPECT_EQ(outcome(trial(c.error, c.sigma, c.tolerance)), c.expected) << c.error << " " << c.sigma;
  }
  EXPECT_EQ(outcome(trial(9.0, 1.0, 0.0, "", true)), Outcome::refused);
}

TEST(LimitMap, CountsWhatWasFlaggedOfRightAndWrong) {
  const LimitCount count = count_of(small_map());
  EXPECT_EQ(count.right, 2);
  EXPECT_EQ(count.right_flagged, 1);
  EXPECT_EQ(count.wrong, 3);
  EXPECT_EQ(count.wrong_flagged, 2);
  EXPECT_EQ(count.uncertain, 1);
  EXPECT_EQ(count.refused, 1);
  EXPECT_DOUBLE_EQ(count.flagged_share(), 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(count.false_alarm_share(), 0.5);
  EXPECT_EQ(count_at(small_map(), {3.0, 2.0}).right, 0);
  EXPECT_EQ(LimitCount{}.flagged_share(), 1.0);
  EXPECT_EQ(LimitCount{}.false_alarm_share(), 0.0);
}

TEST(LimitMap, TableHasARowForEachTrialWithEmptyFieldsForWhatIsNoNumber) {
  const std::string csv = limits_csv({small_map()});
  EXPECT_THAT(csv, StartsWith("map,parameter_1,value_1,parameter_2,value_2,parameter_3,value_3,seed,quantity,"
                              "error,sigma,tolerance,outcome,flags\n"));
  EXPECT_THAT(csv, HasSubstr("\nsmall,x [m],1,y [s],2,,,1,length (relative),,1,0,wrong,coarse\n"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 8);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), ','), 8 * 13);
}

TEST(LimitMap, PictureAndPageShowCountsAndTheSentence) {
  const std::string svg = limit_svg(small_map());
  EXPECT_THAT(svg, HasSubstr("A &amp; B"));
  EXPECT_THAT(
      svg,
      HasSubstr("1 right; 1 right, flagged; 1 uncertain; 2 wrong, flagged; 1 wrong, no flag; 1 refused"));
  EXPECT_THAT(svg, HasSubstr("It bends; noticed by a crack; then stops."));
  EXPECT_THAT(limit_page({small_map()}, "struna limits -o out"), HasSubstr("struna limits -o out"));
}

TEST(LimitMap, AxesAreThinnedButKeepTheirEnds) {
  LimitRun run;
  run.every = 3;
  EXPECT_THAT(run.axis("x", {1, 2, 3, 4, 5, 6}).values, testing::ElementsAre(1, 4, 6));
}

TEST(LimitMap, DrawsBeginAtTheFirstSeed) {
  LimitRun run;
  EXPECT_THAT(run.draws(2), testing::ElementsAre(1u, 2u));
  run.seeds = 3;
  run.first_seed = 7;
  EXPECT_THAT(run.draws(2), testing::ElementsAre(7u, 8u, 9u));
}

TEST(LimitMap, EveryMapHasANameOfItsOwn) {
  std::vector<std::string> names;
  for (const auto& known : known_limits()) names.push_back(known.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
}

// The shares asserted are those of the whole maps (docs/limits.md), less what few trials may scatter.

TEST(Limits, ModesOfTheAutomaticMethodAreRightOrFlagged) {
  LimitRun run;
  run.seeds = 1;
  const LimitMap map = multi_mode_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_GE(all.flagged_share(), 0.9);  // of some 100: 2 %
  EXPECT_LE(all.false_alarm_share(), 0.05);
  EXPECT_GT(all.wrong, 60);  // both sides of the border are there
  EXPECT_GT(all.right, 100);
  const LimitCount apart = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] >= 3.0; }));
  EXPECT_EQ(apart.wrong, 0);
  const LimitCount together = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] <= 0.1; }));
  EXPECT_GT(3 * together.wrong, together.right);
}

TEST(Limits, LossFactorsThatAWindowWidensAreFlagged) {
  LimitRun run;
  run.seeds = 2;
  run.every = 2;
  const LimitMap map = leakage_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_GE(all.flagged_share(), 0.95);
  EXPECT_LE(all.false_alarm_share(), 0.1);  // 0.03 to 0.05 of the whole map
  EXPECT_GT(all.uncertain, 5);
  const LimitCount fine = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] >= 24.0; }));
  EXPECT_GT(fine.right, 0);
  EXPECT_EQ(fine.right_flagged, 0);
}

TEST(Limits, PeaksThatAWindowLowersAreToldOf) {
  LimitRun run;
  run.seeds = 2;
  run.every = 2;
  const LimitMap map = leakage_peak_limits(run);
  EXPECT_EQ(count_of(map).flagged_share(), 1.0);
  EXPECT_LE(count_of(map).false_alarm_share(), 0.05);
  const auto at_most = [](double lines) { return [lines](const LimitTrial& t) { return t.at[0] <= lines; }; };
  EXPECT_EQ(count_of(part_of(map, at_most(2.0))).right, 0);
  EXPECT_GT(count_of(part_of(map, at_most(1.0))).wrong, 0);
  EXPECT_GT(count_of(map).right, 20);
}

TEST(Limits, CirclesOfCloseModesAreWrongAndSingleOnesRight) {
  LimitRun run;
  run.seeds = 4;
  const LimitMap map = circle_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_GT(all.wrong, 1000);
  EXPECT_GE(all.flagged_share(), 0.98);  // 0.998 over many draws
  EXPECT_GT(all.right, 260);
  // 0.03 over many draws; a draw's noise is the same at all places, so four scatter by 0.015.
  EXPECT_LE(all.false_alarm_share(), 0.075);
  const LimitCount apart = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] >= 15.0; }));
  EXPECT_GT(apart.right, 20 * apart.wrong);
  const LimitCount together = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] <= 0.4; }));
  EXPECT_GT(together.wrong, together.right);
}

TEST(Limits, RayleighCoefficientsThatModesContradictAreFlagged) {
  LimitRun run;
  run.seeds = 4;
  const LimitMap map = rayleigh_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_GE(all.flagged_share(), 0.95);
  EXPECT_GT(all.wrong, 50);
  const LimitCount pure =
      count_of(part_of(map, [](const LimitTrial& t) { return t.at[1] == 0.0 && t.at[0] >= 3.0; }));
  EXPECT_EQ(pure.wrong, 0);
  EXPECT_LE(pure.false_alarm_share(), 0.05);
  const LimitCount tested = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] >= 3.0; }));
  EXPECT_GE(tested.flagged_share(), 0.95);
  EXPECT_LE(tested.false_alarm_share(), 0.06);
  EXPECT_EQ(count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] == 1.0; })).refused, 84);
}

TEST(Limits, ModuliBeyondTheDataHaveHonestStandardErrors) {
  LimitRun run;
  run.seeds = 2;
  run.every = 2;
  const LimitMap map = extrapolation_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_LT(100 * all.wrong, all.right + all.uncertain);  // 0.5 % of the whole map
  EXPECT_LE(all.false_alarm_share(), 0.1);                // 4 % of the whole map
  const auto inside = [](const LimitTrial& t) { return t.at[0] >= 60.0 && t.at[0] <= 450.0; };
  EXPECT_EQ(count_of(part_of(map, inside)).right_flagged, 0);
  long uncertain = 0, flagged = 0;
  for (const LimitTrial& t : map.trials) {
    if (inside(t) || outcome(t) != Outcome::uncertain) continue;
    ++uncertain;
    flagged += !t.flags.empty();
  }
  EXPECT_GT(uncertain, 20);
  EXPECT_GT(4 * flagged, 3 * uncertain);
}

TEST(Limits, NewmarkWarnsWhereItsStepDrifts) {
  LimitRun run;
  run.seeds = 1;
  run.every = 2;
  const LimitMap map = newmark_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_GE(all.flagged_share(), 0.95);
  EXPECT_LE(all.false_alarm_share(), 0.05);
  EXPECT_GT(all.wrong, 5);
  EXPECT_GT(all.right, 5);
  const LimitCount fine = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] >= 256.0; }));
  EXPECT_EQ(fine.wrong, 0);
  const LimitCount rough = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] <= 4.0; }));
  EXPECT_EQ(rough.right, 0);
}

TEST(Limits, FixedStepsInContactAreCheckedOnBothSides) {
  LimitRun run;
  run.seeds = 1;
  run.every = 10;  // the ends of each axis
  const LimitMap newmark = newmark_contact_limits(run);
  const LimitCount all = count_of(newmark);
  EXPECT_EQ(all.wrong_flagged, all.wrong);
  EXPECT_LE(all.right_flagged, 1);
  const LimitCount fine = count_of(part_of(newmark, [](const LimitTrial& t) { return t.at[0] <= 10.0; }));
  EXPECT_GT(fine.right, fine.wrong);
  const LimitCount rough = count_of(part_of(newmark, [](const LimitTrial& t) { return t.at[0] >= 100.0; }));
  EXPECT_GT(rough.wrong, 0);
}

TEST(Limits, TolerancesInContactAreKeptOrTold) {
  LimitRun run;
  run.seeds = 1;
  run.every = 10;  // the ends of each axis
  const LimitCount all = count_of(contact_tolerance_limits(run));
  EXPECT_EQ(all.wrong_flagged, all.wrong);
  EXPECT_GE(all.right, 6);
  EXPECT_LE(all.right_flagged, 1);
}

TEST(Limits, WallsTooStiffForStepsAreRefusedOrTold) {
  LimitRun run;
  run.seeds = 1;
  run.every = 10;
  const LimitMap map = stiff_wall_limits(run);
  for (const LimitTrial& t : map.trials) EXPECT_EQ(t.refused, t.at[0] >= 12.0) << t.at[0];
  const LimitCount all = count_of(map);
  EXPECT_EQ(all.wrong_flagged, all.wrong);  // Newmark's step of 100 us
  EXPECT_GE(all.wrong, 1);
  EXPECT_GE(all.right, 3);
  EXPECT_EQ(all.right_flagged, 0);
  EXPECT_EQ(all.refused, 4);
  const auto far = [](const LimitTrial& t) {
    return t.refused && t.at[2] == 0.0 && !(t.error <= t.tolerance);
  };
  EXPECT_EQ(part_of(map, far).trials.size(), 2U);  // what is refused would have missed its tolerance
}

TEST(Limits, NewmarkPairsThatGrowAreRefusedAndThoseThatDampAreToldOf) {
  LimitRun run;
  run.seeds = 1;
  run.every = 2;
  const LimitMap map = newmark_parameter_limits(run);
  for (const LimitTrial& t : map.trials) {
    const bool stable = t.at[1] >= 0.5 && t.at[0] >= 0.5 * t.at[1];
    EXPECT_EQ(t.refused, !stable) << t.at[0] << " " << t.at[1];
    // Eight steps a period: what the refusal keeps away is no result at all, mostly without bound.
    if (t.refused && t.at[2] == 8.0) {
      EXPECT_FALSE(t.error <= 0.05) << t.at[0] << " " << t.at[1];
    }
  }
  const LimitCount all = count_of(map);
  EXPECT_EQ(all.wrong_flagged, all.wrong);
  EXPECT_GT(all.wrong, 5);
  EXPECT_GT(all.right, 3);
  EXPECT_LE(all.right_flagged, 1);
}

TEST(Limits, NonCausalDampingIsToldOfInTime) {
  LimitRun run;
  run.every = 3;
  const LimitMap map = damping_in_time_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_EQ(all.wrong_flagged, all.wrong);
  EXPECT_LE(all.right_flagged, 1);
  EXPECT_GT(all.wrong, 3);
  EXPECT_GT(all.right, 3);
}

TEST(Limits, ModesLeftToStaticsKeepTheTolerance) {
  LimitRun run;
  run.seeds = 1;
  const LimitMap map = truncation_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_EQ(all.wrong, 0);
  EXPECT_GT(all.right, 10);
  long prevented = 0;  // what the rule keeps away
  for (const LimitTrial& t : map.trials) prevented += t.refused && t.error > t.tolerance;
  EXPECT_GT(prevented, 10);
}

TEST(Limits, SpringsTooSoftForAWallAreToldOf) {
  LimitRun run;
  run.seeds = 1;
  run.every = 10;  // the ends of each axis
  const LimitMap map = penalty_limits(run);
  const LimitCount soft = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] <= 1e-4; }));
  EXPECT_EQ(soft.wrong_flagged, 2);  // at the larger acceleration; at the smaller one nothing touches
  EXPECT_EQ(soft.right, 2);
  EXPECT_EQ(soft.right_flagged, 0);
  const LimitCount stiff = count_of(part_of(map, [](const LimitTrial& t) { return t.at[0] >= 50.0; }));
  EXPECT_EQ(stiff.right, 4);
  EXPECT_EQ(stiff.right_flagged, 0);
}

}  // namespace
}  // namespace struna::apps
