#include "ident/schwarz_penalty.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace struna::ident {
namespace {

TEST(SchwarzPenalty, IsTheLogarithmOfTheDataForEachParameter) {
  EXPECT_DOUBLE_EQ(schwarz_penalty({6.0, 1000.0}), 6.0 * std::log(1000.0));
}

TEST(SchwarzPenalty, DataThatAreWorthHalfHaveTwiceTheScatter) {
  // Each of 500 values written down twice: the sum of squares doubles, and so does the penalty.
  EXPECT_DOUBLE_EQ(schwarz_penalty({6.0, 1000.0, 2.0}), 2.0 * schwarz_penalty({6.0, 500.0}));
  EXPECT_DOUBLE_EQ(schwarz_penalty({6.0, 1000.0, 1.0, 3.0}), 3.0 * schwarz_penalty({6.0, 1000.0}));
}

}  // namespace
}  // namespace struna::ident
