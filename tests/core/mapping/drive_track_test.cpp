#include "core/mapping/drive_track.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

Stamp At(int ms) { return Stamp(std::chrono::milliseconds(1'700'000'000'000 + ms)); }

// Straight on along x, a node every ten metres, a landmark five metres ahead of each.
DriveTrack Straight() {
  DriveTrack track{.name = "straight"};
  for (int i = 0; i < 3; ++i) {
    track.nodes.push_back({.stamp = At(1000 * i),
                           .T_odometry_node = {.translation_m = {10.0 * i, 0.0}},
                           .landmarks = {{.mean_m = {5.0, 1.0},
                                          .covariance_m2 = Eigen::Vector2d(1, 4).asDiagonal()}}});
  }
  return track;
}

TEST(PlaceScanTest, SpreadsWhatEgoMotionMissesOverTheWay) {
  const DriveTrack track = Straight();
  // The survey found that the second stretch is a metre longer.
  const std::vector<Pose2> T_map_nodes = {
      {}, {.translation_m = {10, 0}}, {.translation_m = {21, 0}}};
  const auto x_at = [&](int ms, double odometry_m) {
    return PlaceScan(track, T_map_nodes, {At(ms), {.translation_m = {odometry_m, 0.0}}})
        .translation_m.x();
  };
  EXPECT_NEAR(x_at(500, 5.0), 5.0, 1e-9);
  EXPECT_NEAR(x_at(1500, 15.0), 15.5, 1e-9);
  EXPECT_NEAR(x_at(2000, 20.0), 21.0, 1e-9);
  EXPECT_NEAR(x_at(2100, 21.0), 22.0, 1e-9);  // beyond the last node
  EXPECT_NEAR(x_at(-100, -1.0), -1.0, 1e-9);  // before the first
}

TEST(JoinViewTest, TurnsLandmarksIntoTheMiddleNode) {
  const DriveTrack track = Straight();
  const std::vector<Pose2> T_map_nodes = {
      {}, {.translation_m = {10, 0}, .yaw_rad = M_PI / 2}, {.translation_m = {10, 10}}};
  const std::vector<GaussianPoint<2>> submap = JoinSubmap(track, T_map_nodes, 1, 1);
  ASSERT_EQ(submap.size(), 3U);
  EXPECT_NEAR((submap[0].mean_m - Eigen::Vector2d(1, 5)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(submap[0].covariance_m2(0, 0), 4.0, 1e-9);
  EXPECT_NEAR((submap[1].mean_m - Eigen::Vector2d(5, 1)).norm(), 0.0, 1e-9);
  EXPECT_EQ(JoinSubmap(track, T_map_nodes, 0, 0).size(), 1U);
}

}  // namespace
}  // namespace dcloc
