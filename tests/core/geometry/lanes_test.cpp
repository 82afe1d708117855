#include "core/geometry/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dcloc {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

int CountSet(LaneMask mask) {
  int count = 0;
  for (std::size_t lane = 0; lane < kLaneCount; ++lane) count += mask[lane] != 0 ? 1 : 0;
  return count;
}

TEST(LanesTest, OnlyTheFirstLanesAreTaken) {
  for (std::size_t count = 0; count < 9; ++count) {
    const LaneMask mask = FirstLanes(count);
    EXPECT_EQ(CountSet(mask), static_cast<int>(std::min(count, kLaneCount)));
    EXPECT_EQ(mask[0] != 0, count > 0);
  }
}

TEST(LanesTest, EachLaneIsComputedByItself) {
  const Lanes values = {-4.0F, 0.25F, 9.0F, 1e-30F};
  const Lanes roots = Sqrt(Abs(values));
  for (std::size_t lane = 0; lane < kLaneCount; ++lane) {
    EXPECT_FLOAT_EQ(roots[lane], std::sqrt(std::abs(values[lane])));
    EXPECT_EQ(AtLeast(values, 0.5F)[lane], std::max(values[lane], 0.5F));
  }
  EXPECT_EQ(Least(values), -4.0F);
}

TEST(LanesTest, WhatIsNotANumberIsRaisedToTheFloor) {
  const Lanes values = {kNan, 2.0F, -kNan, 1.0F};
  const Lanes raised = AtLeast(values, 0.0F);
  EXPECT_EQ(raised[0], 0.0F);
  EXPECT_EQ(raised[1], 2.0F);
  EXPECT_EQ(raised[2], 0.0F);
}

TEST(LanesTest, TheLogarithmIsLowByNoMoreThanTheSlack) {
  for (int exponent = -300; exponent <= 300; ++exponent) {
    const float value = std::pow(10.0F, 0.1F * static_cast<float>(exponent));
    const float logarithm = LogFromBelow(InEachLane(value))[1];
    EXPECT_LE(logarithm, std::log(value) + 1e-4F) << value;
    EXPECT_GE(logarithm, std::log(value) - kLogSlack - 1e-4F) << value;
  }
}

}  // namespace
}  // namespace dcloc
