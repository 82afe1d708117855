#include "core/map/map_edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>

#include "core/map/local_map.h"
#include "tests/core/map/synthetic_map.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<const RadarMap> Load(std::vector<std::byte> bytes) {
  auto map = RadarMap::FromBytes(std::move(bytes));
  EXPECT_TRUE(map.ok()) << map.status();
  EXPECT_TRUE((*map)->Verify().ok());
  return *std::move(map);
}

// 40 keyframes on 400 m of spiral, each with 50 points that differ.
EditableMap SpiralMap() {
  SyntheticMap map(40, 50);
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    map.points[i].rcs_dbsm = static_cast<float>(i) * 0.01F;
  }
  return ToEditable(*Load(map.Bytes()));
}

std::vector<std::byte> BytesOf(const EditableMap& map) {
  auto bytes = ToMapBytes(map);
  EXPECT_TRUE(bytes.ok()) << bytes.status();
  return *std::move(bytes);
}

// West of the middle of the spiral's keyframes.
PlanarRegion West(const EditableMap& map) {
  const Eigen::Vector3d middle_m = map.Origin_m() + PoseOf(map.keyframes[20].record).translation_m;
  return {.polygons = {BoxPolygon(middle_m.head<2>() - Eigen::Vector2d(1e4, 1e4),
                                  middle_m.head<2>() + Eigen::Vector2d(0, 1e4))}};
}

EditableMap Keep(const EditableMap& map, RegionSide side) {
  auto part = KeepSide(map, West(map), side);
  EXPECT_TRUE(part.ok()) << part.status();
  return *std::move(part);
}

std::multiset<std::string> Landmarks(const LocalMap<2>& map) {
  std::multiset<std::string> landmarks;
  for (const auto& point : map.points()) {
    landmarks.insert(std::string(reinterpret_cast<const char*>(&point), sizeof(point)));
  }
  return landmarks;
}

TEST(MapPartsTest, TakenApartAndPutTogetherIsTheSameFile) {
  const SyntheticMap map(30, 20);
  EXPECT_EQ(BytesOf(ToEditable(*Load(map.Bytes()))), map.Bytes());
}

TEST(MapPartsTest, WhatNoMapMayHoldIsNotWritten) {
  EditableMap map = SpiralMap();
  map.keyframes[3].points[0].xx_m2 = -1.0F;
  EXPECT_THAT(ToMapBytes(map).status().message(), HasSubstr("point 150"));
  for (EditableKeyframe& keyframe : map.keyframes) keyframe.points.clear();
  EXPECT_EQ(ToMapBytes(map).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(MapEditTest, EachLandmarkIsOnOneSide) {
  const EditableMap map = SpiralMap();
  const EditableMap inside = Keep(map, RegionSide::kInside);
  const EditableMap outside = Keep(map, RegionSide::kOutside);
  EXPECT_GT(inside.PointCount(), 300U);
  EXPECT_GT(outside.PointCount(), 300U);
  EXPECT_EQ(inside.PointCount() + outside.PointCount(), map.PointCount());
  const PlanarRegion west = West(map);
  for (const EditableKeyframe& keyframe : inside.keyframes) {
    Pose3 T_map_keyframe = PoseOf(keyframe.record);
    T_map_keyframe.translation_m += map.Origin_m();
    for (const MapPoint& point : keyframe.points) {
      EXPECT_TRUE(Contains(west, (T_map_keyframe * PositionOf(point)).head<2>()));
    }
  }
}

TEST(MapEditTest, ARegionAroundAllChangesNothing) {
  const EditableMap map = SpiralMap();
  const Eigen::Vector2d origin = map.Origin_m().head<2>();
  const PlanarRegion all{.polygons = {BoxPolygon(origin - Eigen::Vector2d(1e4, 1e4),
                                                 origin + Eigen::Vector2d(1e4, 1e4))}};
  EXPECT_EQ(BytesOf(*KeepSide(map, all, RegionSide::kInside)), BytesOf(map));
  EXPECT_THAT(KeepSide(map, all, RegionSide::kOutside).status().message(),
              HasSubstr("all of the map's 2000 landmarks"));
  EXPECT_FALSE(KeepSide(map, {}, RegionSide::kInside).ok());
}

// What registrations see around every keyframe of the whole is there in the merged halves, bit for
// bit.
TEST(MapEditTest, MergedHalvesShowTheWhole) {
  const EditableMap map = SpiralMap();
  MergeCounts counts;
  const auto merged =
      Merge(Keep(map, RegionSide::kInside), Keep(map, RegionSide::kOutside), counts);
  ASSERT_TRUE(merged.ok()) << merged.status();
  EXPECT_GT(counts.shared_keyframes, 0U);
  EXPECT_EQ(counts.doubled_landmarks, 0U);
  EXPECT_NEAR(merged->info.length_m, map.info.length_m, 1e-9);
  EXPECT_EQ(merged->keyframes.size(), map.keyframes.size());
  const auto whole_map = Load(BytesOf(map));
  const auto merged_map = Load(BytesOf(*merged));
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const Eigen::Vector3d p_map = whole_map->keyframe(i).T_map_keyframe.translation_m;
    EXPECT_EQ(Landmarks(LocalMap<2>(*merged_map, p_map, 60.0)),
              Landmarks(LocalMap<2>(*whole_map, p_map, 60.0)));
  }
}

TEST(MapEditTest, MergingAMapWithItselfIsThatMap) {
  const EditableMap map = SpiralMap();
  MergeCounts counts;
  EXPECT_EQ(BytesOf(*Merge(map, map, counts)), BytesOf(map));
  EXPECT_EQ(counts.shared_landmarks, map.PointCount());
}

TEST(MapEditTest, AMapWithoutKeyframesAddsNoLength) {
  const EditableMap map = SpiralMap();
  EditableMap none = map;
  none.keyframes.clear();
  MergeCounts counts;
  EXPECT_EQ(Merge(map, none, counts)->info.length_m, map.info.length_m);
}

TEST(MapEditTest, StampsAreKnownWhereBothMapsKnowThem) {
  EditableMap known = SpiralMap();
  const EditableMap unknown = known;
  known.info.flags |= kHasKnownStampsFlag;
  MergeCounts counts;
  EXPECT_EQ(Merge(known, known, counts)->info.flags, known.info.flags);
  EXPECT_EQ(Merge(known, unknown, counts)->info.flags, unknown.info.flags);
  EXPECT_EQ(Merge(unknown, known, counts)->info.flags, unknown.info.flags);
  known.info.flags |= 100U << kStampDelayShift;
  EXPECT_EQ(Merge(known, known, counts)->info.flags, known.info.flags);
  EXPECT_EQ(Merge(known, unknown, counts).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(MapEditTest, AnchorsTieFramesTogether) {
  EditableMap a = SpiralMap();
  a.info.local_origin_m = {10.0, 20.0, 0.0};
  a.info.flags |= kHasAnchorFlag;
  a.info.anchor_latitude_deg = 48.0;
  a.info.anchor_longitude_deg = 9.0;
  a.info.anchor_x_axis_east_rad = 0.3;
  // The same map in the frame of another anchor, 700 m away and turned.
  const GeodeticAnchor other{.origin = GeodeticFromMap(*a.Anchor(), {500.0, -500.0, 3.0}),
                             .x_axis_east_rad = -1.0};
  const Pose3 T_b_a = FrameChange(other, *a.Anchor());
  EXPECT_LT((T_b_a * Eigen::Vector3d(500.0, -500.0, 3.0)).norm(), 1e-6);
  EditableMap b = a;
  b.info.anchor_latitude_deg = other.origin.latitude_deg;
  b.info.anchor_longitude_deg = other.origin.longitude_deg;
  b.info.anchor_height_m = other.origin.height_m;
  b.info.anchor_x_axis_east_rad = other.x_axis_east_rad;
  b.info.local_origin_m = {0.0, 0.0, 0.0};
  for (EditableKeyframe& keyframe : b.keyframes) {
    Pose3 pose = PoseOf(keyframe.record);
    pose.translation_m += a.Origin_m();
    pose = T_b_a * pose;
    const auto& t = pose.translation_m;
    const auto& q = pose.rotation;
    keyframe.record.translation_local_m = {t.x(), t.y(), t.z()};
    keyframe.record.rotation_wxyz = {q.w(), q.x(), q.y(), q.z()};
  }
  MergeCounts counts;
  const auto merged = Merge(a, b, counts);
  ASSERT_TRUE(merged.ok()) << merged.status();
  ASSERT_EQ(merged->keyframes.size(), 80U);
  EXPECT_EQ(counts.doubled_landmarks, a.PointCount());
  for (std::size_t i = 0; i < 40; ++i) {
    const Pose3 off =
        PoseOf(merged->keyframes[i].record).Inverse() * PoseOf(merged->keyframes[40 + i].record);
    EXPECT_LT(off.translation_m.norm(), 1e-5);
    EXPECT_LT(RotationAngle(off), 1e-8);
  }
}

TEST(MapEditTest, MapsThatDoNotFitTogetherAreRefused) {
  const EditableMap a = SpiralMap();
  EditableMap b = a;
  b.name = "other";
  EXPECT_THAT(CheckFrames(a, b, false).message(), HasSubstr("\"spiral\" has no anchor"));
  EXPECT_TRUE(CheckFrames(a, b, true).ok());
  b.info.flags |= kHasElevationFlag;
  MergeCounts counts;
  EXPECT_THAT(Merge(a, b, counts).status().message(), HasSubstr("flags are 0 and 1"));
}

}  // namespace
}  // namespace dcloc
