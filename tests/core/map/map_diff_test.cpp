#include "core/map/map_diff.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/pose.h"
#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

// One keyframe at (100, 50) that looks along +y, with landmarks at these places of its frame.
EditableMap MapWith(const std::vector<Eigen::Vector2f>& places) {
  EditableMap map{.info = {}, .name = "place", .description = "", .keyframes = {}};
  map.info.index_cell_m = 32.0;
  map.info.local_origin_m = {100.0, 50.0, 0.0};
  EditableKeyframe keyframe;
  const double half = M_PI / 4.0;
  keyframe.record.rotation_wxyz = {std::cos(half), 0.0, 0.0, std::sin(half)};
  for (const Eigen::Vector2f& p : places) {
    MapPoint point{};
    point.x_m = p.x();
    point.y_m = p.y();
    keyframe.points.push_back(point);
  }
  map.keyframes.push_back(keyframe);
  return map;
}

TEST(MapDiffTest, NamesWhatCameWentAndMovedInTheMapFrame) {
  const EditableMap before = MapWith({{10, 0}, {20, 0}, {30, 5}});
  const EditableMap after = MapWith({{10.1F, 0}, {30, 6}, {-15, 0}});
  const auto diff = Compare(before, after, {});
  ASSERT_TRUE(diff.ok()) << diff.status();
  EXPECT_EQ(diff->same.size(), 1U);
  EXPECT_NEAR(diff->same_rms_m, 0.1, 1e-6);
  ASSERT_EQ(diff->removed.size(), 1U);
  EXPECT_LT((diff->removed[0].p_map - Eigen::Vector3d(100, 70, 0)).norm(), 1e-5);
  ASSERT_EQ(diff->added.size(), 1U);
  EXPECT_LT((diff->added[0].p_map - Eigen::Vector3d(100, 35, 0)).norm(), 1e-5);
  ASSERT_EQ(diff->moved.size(), 1U);
  EXPECT_LT((diff->moved[0].before.p_map - Eigen::Vector3d(95, 80, 0)).norm(), 1e-5);
  EXPECT_LT((diff->moved[0].after.p_map - Eigen::Vector3d(94, 80, 0)).norm(), 1e-5);
}

TEST(MapDiffTest, PairsAreOneToOneNearestFirst) {
  const auto diff = Compare(MapWith({{10, 0}, {10.3F, 0}}), MapWith({{10.25F, 0}}), {});
  ASSERT_TRUE(diff.ok());
  EXPECT_EQ(diff->same.size(), 1U);
  ASSERT_EQ(diff->removed.size(), 1U);
  EXPECT_NEAR(diff->removed[0].p_map.y(), 60.0, 1e-5);
}

TEST(MapDiffTest, GroundThatOneMapDoesNotCoverIsNoChange) {
  const EditableMap before = MapWith({{10, 0}, {70, 0}});
  const auto diff = Compare(before, MapWith({{10, 0}}), {});
  ASSERT_TRUE(diff.ok());
  EXPECT_TRUE(diff->removed.empty());
  EXPECT_EQ(diff->only_old_covers_count, 1U);
}

TEST(MapDiffTest, EachKeyframeCoversItsGround) {
  // Landmarks in turn near the one and the other of two keyframes, and far from both.
  const EditableMap before = MapWith({{10, 0}, {210, 0}, {100, 0}, {20, 0}, {220, 0}, {110, 0}});
  EditableMap after = MapWith({});
  after.keyframes.push_back(after.keyframes[0]);
  after.keyframes[1].record.translation_local_m[1] = 200.0;
  const auto diff = Compare(before, after, {});
  ASSERT_TRUE(diff.ok());
  EXPECT_EQ(diff->removed.size(), 4U);
  EXPECT_EQ(diff->only_old_covers_count, 2U);
}

TEST(MapDiffTest, AMapDoesNotDifferFromItself) {
  const EditableMap map = MapWith({{1, 1}, {2, 2}, {2.1F, 2}, {50, -3}});
  const auto diff = Compare(map, map, {});
  ASSERT_TRUE(diff.ok());
  EXPECT_EQ(diff->same.size(), 4U);
  EXPECT_TRUE(diff->added.empty() && diff->removed.empty() && diff->moved.empty());
}

TEST(MapDiffTest, OptionsHaveBounds) {
  EXPECT_THAT(Compare({}, {}, {.same_m = -1.0}).status().message(),
              HasSubstr("same_m is -1; it must lie in [0.001, 10]"));
}

}  // namespace
}  // namespace dcloc
