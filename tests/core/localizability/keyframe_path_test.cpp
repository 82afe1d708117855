#include "core/localizability/keyframe_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/map/editable_map.h"
#include "tests/core/localizability/row_map.h"

namespace dcloc {
namespace {

std::shared_ptr<const RadarMap> MapOf(const std::vector<Pose2>& keyframes) {
  EditableMap map = ToEditable(*RowMap(keyframes.size(), {{.x_m = 1.0}}));
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const Pose3 pose = Embed(keyframes[i]);
    map.keyframes[i].record.translation_local_m = {pose.translation_m.x(), pose.translation_m.y(),
                                                   0.0};
    map.keyframes[i].record.rotation_wxyz = {pose.rotation.w(), 0.0, 0.0, pose.rotation.z()};
  }
  return RadarMap::FromBytes(ToMapBytes(map).value()).value();
}

TEST(KeyframePathTest, AGapEndsAStretch) {
  const auto map = MapOf({{{0, 0}, 0}, {{10, 0}, 0}, {{200, 0}, 0}, {{210, 0}, 0}, {{500, 0}, 0}});
  const std::vector<Stretch> stretches = StretchesOf(*map);
  ASSERT_EQ(stretches.size(), 2U);
  EXPECT_EQ(stretches[0].begin, 0U);
  EXPECT_EQ(stretches[0].end, 2U);
  EXPECT_EQ(stretches[1].begin, 2U);
  EXPECT_EQ(stretches[1].end, 4U);
}

TEST(KeyframePathTest, PassesThroughTheKeyframesWithoutALeapOfVelocity) {
  const std::vector<Pose2> keyframes = {
      {{0, 0}, 0.0}, {{10, 0}, 0.0}, {{19, 3}, 0.7}, {{24, 11}, 1.4}, {{24, 21}, 1.5707}};
  const auto map = MapOf(keyframes);
  const KeyframePath path(*map, {0, 5}, 8.0);
  constexpr double kStep_s = 0.001;
  for (const Pose2& keyframe : keyframes) {
    double nearest_m = INFINITY;
    for (int i = 0; i * kStep_s <= path.duration_s(); ++i) {
      const double time_s = i * kStep_s;
      const Pose2 pose = Flatten(path.At(time_s).T_map_vehicle);
      nearest_m = std::min(nearest_m, (pose.translation_m - keyframe.translation_m).norm());
    }
    EXPECT_LT(nearest_m, 0.01);
  }
  for (int i = 10; (i + 1) * kStep_s < path.duration_s(); ++i) {
    const double time_s = i * kStep_s;
    const PathPoint before = path.At(time_s);
    const PathPoint after = path.At(time_s + kStep_s);
    const Vector6d way = Log(before.T_map_vehicle.Inverse() * after.T_map_vehicle) / kStep_s;
    EXPECT_NEAR(way(0), before.velocity.linear_mps.x(), 0.05);
    EXPECT_NEAR(way(5), before.velocity.angular_radps.z(), 0.01);
    EXPECT_NEAR(after.velocity.linear_mps.x(), before.velocity.linear_mps.x(), 0.05);
    EXPECT_LT(std::abs(before.velocity.angular_radps.z()), 0.8);
  }
}

TEST(KeyframePathTest, SaysWhichKeyframeIsNext) {
  const auto map = RowMap(3, {{.x_m = 1.0}});
  const KeyframePath path(*map, {0, 3}, 10.0);
  EXPECT_DOUBLE_EQ(path.duration_s(), 2.0);
  EXPECT_EQ(path.At(0.4).nearest_keyframe, 0U);
  EXPECT_EQ(path.At(0.6).nearest_keyframe, 1U);
  EXPECT_EQ(path.At(2.0).nearest_keyframe, 2U);
}

TEST(KeyframePathTest, ComesFromBeforeTheFirstKeyframe) {
  const auto map = RowMap(3, {{.x_m = 1.0}});
  const KeyframePath path(*map, {0, 3}, 10.0, 30.0);
  EXPECT_DOUBLE_EQ(path.lead_s(), 3.0);
  EXPECT_DOUBLE_EQ(path.duration_s(), 5.0);
  EXPECT_NEAR(path.At(0.0).T_map_vehicle.translation_m.x(), -30.0, 1e-9);
  EXPECT_EQ(path.At(1.0).nearest_keyframe, 0U);
  EXPECT_EQ(path.At(3.4).nearest_keyframe, 0U);
  EXPECT_EQ(path.At(3.6).nearest_keyframe, 1U);
}

}  // namespace
}  // namespace dcloc
