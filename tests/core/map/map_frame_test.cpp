#include "core/map/map_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/geometry/degrees.h"
#include "tests/core/map/synthetic_map.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

EditableMap SomeMap() {
  return ToEditable(*RadarMap::FromBytes(SyntheticMap(5, 8).Bytes()).value());
}

Eigen::Vector3d PointIn(const EditableMap& map, std::size_t keyframe, std::size_t point) {
  Pose3 T_map_keyframe = PoseOf(map.keyframes[keyframe].record);
  T_map_keyframe.translation_m += map.Origin_m();
  return T_map_keyframe * PositionOf(map.keyframes[keyframe].points[point]);
}

TEST(MapFrameTest, EveryLandmarkMovesWithTheFrame) {
  const EditableMap map = SomeMap();
  Pose3 T_new_map = Embed({{300.0, -40.0}, 1.2});
  T_new_map.translation_m.z() = 5.0;
  const GeodeticAnchor anchor{.origin = {.latitude_deg = 48.0, .longitude_deg = 9.0}};
  const auto moved = MoveTo(map, T_new_map, anchor);
  ASSERT_TRUE(moved.ok()) << moved.status();
  EXPECT_TRUE(ToMapBytes(*moved).ok()) << ToMapBytes(*moved).status();
  EXPECT_EQ(moved->Anchor()->origin.latitude_deg, 48.0);
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    EXPECT_LT((PointIn(*moved, i, 3) - T_new_map * PointIn(map, i, 3)).norm(), 1e-6);
  }
  EXPECT_FALSE(MoveTo(*moved, T_new_map.Inverse(), std::nullopt)->Anchor().has_value());
}

TEST(MapFrameTest, WhatLiesTooFarAwayIsRefused) {
  const auto moved = MoveTo(SomeMap(), Embed({{2e9, 0.0}, 0.0}), std::nullopt);
  EXPECT_EQ(moved.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(moved.status().message()), HasSubstr("must lie within 1e+09 m"));
}

std::vector<ControlPoint> PointsOf(const GeodeticAnchor& anchor) {
  std::vector<ControlPoint> points;
  for (const Eigen::Vector2d& p_m : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(2000.0, 100.0),
                                     Eigen::Vector2d(500.0, 1500.0), Eigen::Vector2d(-800, 400)}) {
    points.push_back({p_m, GeodeticFromMap(anchor, {p_m.x(), p_m.y(), 0.0})});
  }
  return points;
}

TEST(MapFrameTest, ControlPointsGiveTheAnchor) {
  const GeodeticAnchor anchor{
      .origin = {.latitude_deg = 48.7, .longitude_deg = 9.1, .height_m = 300.0},
      .x_axis_east_rad = -2.0};
  const auto fit = FitAnchor(PointsOf(anchor));
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_NEAR(fit->anchor.origin.latitude_deg, 48.7, 1e-8);
  EXPECT_NEAR(fit->anchor.origin.longitude_deg, 9.1, 1e-8);
  EXPECT_NEAR(fit->anchor.x_axis_east_rad, -2.0, 1e-6);
  for (const double residual_m : fit->residual_m) EXPECT_LT(residual_m, 0.01);
  ASSERT_EQ(fit->left_out_m.size(), 4U);
}

TEST(MapFrameTest, AWrongPointShowsWhereTheOthersPutIt) {
  const GeodeticAnchor anchor{.origin = {.latitude_deg = 48.7, .longitude_deg = 9.1}};
  std::vector<ControlPoint> points = PointsOf(anchor);
  points[2].p_map_m.x() += 10.0;
  const auto fit = FitAnchor(points);
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_NEAR(fit->left_out_m[2], 10.0, 0.1);
  EXPECT_LT(fit->residual_m[2], 9.0);
}

TEST(MapFrameTest, PointsThatSayTooLittleAreRefused) {
  const GeodeticAnchor anchor{.origin = {.latitude_deg = 48.7, .longitude_deg = 9.1}};
  std::vector<ControlPoint> points = PointsOf(anchor);
  points.resize(1);
  EXPECT_THAT(std::string(FitAnchor(points).status().message()), HasSubstr("two at least"));
  points.push_back(points.front());
  EXPECT_THAT(std::string(FitAnchor(points).status().message()),
              HasSubstr("nothing of the heading"));
}

}  // namespace
}  // namespace dcloc
