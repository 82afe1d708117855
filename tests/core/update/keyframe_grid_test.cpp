#include "core/update/keyframe_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/map/keyframe_index.h"
#include "core/update/updated_keyframes.h"

namespace dcloc {
namespace {

Pose3 At(double x_m, double y_m) { return {.translation_m = {x_m, y_m, 0.0}}; }

Landmark LandmarkAt(double x_m, double y_m) { return {.position_m = {x_m, y_m, 0.0}}; }

TEST(KeyframeGridTest, FindsTheOneThatASearchThroughAllFinds) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate_m(-900.0, 900.0);
  std::vector<Pose3> keyframes(60);
  for (Pose3& keyframe : keyframes) keyframe = At(coordinate_m(random), coordinate_m(random));
  const KeyframeGrid grid(keyframes);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d p_m(2.0 * coordinate_m(random), 2.0 * coordinate_m(random));
    const auto nearest = std::ranges::min_element(keyframes, {}, [&](const Pose3& keyframe) {
      return (keyframe.translation_m.head<2>() - p_m).norm();
    });
    EXPECT_EQ(grid.Nearest(p_m), static_cast<std::size_t>(nearest - keyframes.begin()));
  }
}

TEST(KeyframeGridTest, OfSeveralThatAreAsNearTheFirst) {
  const std::vector<Pose3> keyframes = {At(30.0, 0.0), At(-5.0, 0.0), At(5.0, 0.0), At(5.0, 0.0)};
  EXPECT_EQ(KeyframeGrid(keyframes).Nearest({0.0, 0.0}), 1U);
  EXPECT_EQ(KeyframeGrid(keyframes).Nearest({4.0, 0.0}), 2U);
}

TEST(UpdatedKeyframesTest, ALandmarkBelongsToTheNearestStreet) {
  const std::vector<Pose3> base = {At(0.0, 0.0), At(50.0, 0.0)};
  const std::vector<Pose3> joined = {At(50.0, 40.0)};
  const UpdatedKeyframes keyframes(base, joined);
  EXPECT_TRUE(keyframes.AnyJoined());
  EXPECT_EQ(keyframes.Of(LandmarkAt(40.0, 5.0)), 1U);
  EXPECT_FALSE(keyframes.IsInJoinedStreet(LandmarkAt(40.0, 5.0)));
  EXPECT_EQ(keyframes.Of(LandmarkAt(50.0, 30.0)), 2U);
  EXPECT_TRUE(keyframes.IsInJoinedStreet(LandmarkAt(50.0, 30.0)));
  EXPECT_FALSE(UpdatedKeyframes(base, {}).AnyJoined());
}

TEST(UpdatedKeyframesTest, WhatIsFarBelongsToNone) {
  const std::vector<Pose3> base = {At(0.0, 0.0)};
  const UpdatedKeyframes keyframes(base, {});
  EXPECT_FALSE(keyframes.Of(LandmarkAt(0.0, kMaxKeyframeDistance_m)).has_value());
  EXPECT_TRUE(keyframes.Of(LandmarkAt(0.0, 0.99 * kMaxKeyframeDistance_m)).has_value());
  EXPECT_FALSE(keyframes.IsInJoinedStreet(LandmarkAt(0.0, 500.0)));
}

}  // namespace
}  // namespace dcloc
