#include "core/map/keyframe_accuracy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace dcloc {
namespace {

TEST(KeyframeAccuracyTest, ComesBackToOnePercent) {
  for (const double sigma : {0.001, 0.0123, 0.3, 4.5, 20.0}) {
    const KeyframeAccuracy accuracy{
        .sigmas = {{.along_m = sigma, .across_m = 2.0 * sigma / 3.0, .heading_rad = sigma / 20.0}},
        .is_tunnel = true,
        .is_alias = false};
    const std::uint32_t word = PackAccuracy(accuracy);
    EXPECT_TRUE(IsAccuracyWord(word));
    const auto back = UnpackAccuracy(word);
    ASSERT_TRUE(back.has_value() && back->sigmas.has_value());
    EXPECT_NEAR(back->sigmas->along_m, sigma, 0.0101 * sigma);
    EXPECT_NEAR(back->sigmas->heading_rad, std::max(sigma / 20.0, 1e-4), 0.0101 * sigma / 20.0);
    EXPECT_TRUE(back->is_tunnel);
    EXPECT_FALSE(back->is_alias);
    EXPECT_EQ(PackAccuracy(*back), word);
  }
}

TEST(KeyframeAccuracyTest, WhatIsBeyondAWordIsItsNearest) {
  const KeyframeAccuracy accuracy{
      .sigmas = {{.along_m = 1e9, .across_m = 0.0, .heading_rad = 100.0}}};
  const auto back = UnpackAccuracy(PackAccuracy(accuracy));
  EXPECT_NEAR(back->sigmas->along_m, 24.0, 0.5);
  EXPECT_EQ(back->sigmas->across_m, 1e-3);
  EXPECT_NEAR(back->sigmas->heading_rad, 2.4, 0.05);
}

TEST(KeyframeAccuracyTest, NothingIsNotTheSameAsNoPose) {
  EXPECT_FALSE(UnpackAccuracy(0).has_value());
  const std::uint32_t word = PackAccuracy({.is_alias = true});
  EXPECT_NE(word, 0U);
  const auto back = UnpackAccuracy(word);
  ASSERT_TRUE(back.has_value());
  EXPECT_FALSE(back->sigmas.has_value());
  EXPECT_TRUE(back->is_alias);
}

TEST(KeyframeAccuracyTest, OtherWordsMeanNothing) {
  EXPECT_TRUE(IsAccuracyWord(0));
  EXPECT_FALSE(IsAccuracyWord(1));                        // nobody has looked
  EXPECT_FALSE(IsAccuracyWord((1U << 29) | 5U));          // along, and not across
  EXPECT_FALSE(IsAccuracyWord((1U << 29) | (1U << 30)));  // a bit of a later version
  EXPECT_TRUE(IsAccuracyWord(1U << 29));
}

}  // namespace
}  // namespace dcloc
