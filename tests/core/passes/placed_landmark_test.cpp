#include "core/passes/placed_landmark.h"

#include <gtest/gtest.h>

#include <numbers>

namespace dcloc {
namespace {

// Two keyframes, the second turned to the left by a quarter.
EditableMap TwoKeyframes() {
  EditableMap map;
  MapPoint ahead{};
  ahead.x_m = 5.0F;
  ahead.xx_m2 = 0.04F;
  ahead.yy_m2 = 0.01F;
  const auto keyframe = [&](double x_m, double yaw_rad) {
    return EditableKeyframe{
        .record = RecordOf(Embed(Pose2{.translation_m = {x_m, 0.0}, .yaw_rad = yaw_rad})),
        .points = {ahead}};
  };
  map.keyframes = {keyframe(0.0, 0.0), keyframe(10.0, 0.5 * std::numbers::pi)};
  return map;
}

TEST(PlacedLandmarkTest, LandmarksLieAndScatterAsTheirKeyframesAreTurned) {
  const std::vector<PlacedLandmark> landmarks = LandmarksOf(TwoKeyframes());
  ASSERT_EQ(landmarks.size(), 2U);
  EXPECT_NEAR((landmarks[0].position.position_m - Eigen::Vector2d(5.0, 0.0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((landmarks[1].position.position_m - Eigen::Vector2d(10.0, 5.0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR(landmarks[0].position.covariance_m2(0, 0), 0.04, 1e-6);
  EXPECT_NEAR(landmarks[1].position.covariance_m2(0, 0), 0.01, 1e-6);
  EXPECT_NEAR(landmarks[1].position.covariance_m2(1, 1), 0.04, 1e-6);
  EXPECT_EQ(landmarks[1].keyframe, 1U);
}

TEST(PlacedLandmarkTest, PositionsAreInTheirOrder) {
  const std::vector<PlacedLandmark> landmarks = LandmarksOf(TwoKeyframes());
  const std::vector<LandmarkPosition> positions = PositionsOf(landmarks);
  ASSERT_EQ(positions.size(), 2U);
  EXPECT_EQ(positions[1].position_m, landmarks[1].position.position_m);
}

}  // namespace
}  // namespace dcloc
