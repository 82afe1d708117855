#include "core/map/map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "core/map/radar_map.h"
#include "tests/core/map/synthetic_map.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

// Opens and verifies.
absl::Status Check(std::vector<std::byte> bytes) {
  const auto map = RadarMap::FromBytes(std::move(bytes));
  return map.ok() ? (*map)->Verify() : map.status();
}

TEST(MapFileTest, RoundTrip) {
  SyntheticMap written(25, 40);
  written.info.flags = kHasAnchorFlag | kHasElevationFlag;
  written.info.anchor_latitude_deg = 48.5;
  written.info.anchor_longitude_deg = 9.9;
  written.info.anchor_height_m = 480.0;
  written.info.anchor_x_axis_east_rad = 0.3;
  const auto map = RadarMap::FromBytes(written.Bytes());
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_TRUE((*map)->Verify().ok()) << (*map)->Verify();

  const MapInfo& info = (*map)->info();
  EXPECT_EQ(info.name, "spiral");
  EXPECT_EQ(info.description, "made up");
  EXPECT_EQ(info.keyframe_count, 25U);
  EXPECT_EQ(info.point_count, 1000U);
  EXPECT_EQ(info.size_bytes, (*map)->bytes().size());
  EXPECT_EQ(info.length_m, 250.0);
  EXPECT_TRUE(info.has_elevation);
  ASSERT_TRUE(info.anchor.has_value());
  EXPECT_EQ(info.anchor->origin.latitude_deg, 48.5);
  EXPECT_EQ(info.anchor->x_axis_east_rad, 0.3);

  Eigen::Vector3d min_map_m = Eigen::Vector3d::Constant(1e12);
  for (std::size_t i = 0; i < info.keyframe_count; ++i) {
    const Keyframe keyframe = (*map)->keyframe(i);
    const KeyframeRecord& record = written.keyframes[i];
    EXPECT_EQ(keyframe.T_map_keyframe.translation_m.x(), 5e5 + record.translation_local_m[0]);
    EXPECT_EQ(keyframe.T_map_keyframe.rotation.z(), record.rotation_wxyz[3]);
    ASSERT_EQ(keyframe.points.size(), 40U);
    EXPECT_EQ(keyframe.points[39].x_m, written.points[40 * i + 39].x_m);
    EXPECT_EQ(keyframe.points[39].zz_m2, written.points[40 * i + 39].zz_m2);
    EXPECT_EQ(keyframe.points[39].scan_count, 7);
    min_map_m = min_map_m.cwiseMin(keyframe.T_map_keyframe.translation_m);
  }
  EXPECT_EQ(info.min_map_m, min_map_m);
}

TEST(MapFileTest, AMapWithoutKeyframesIsValidAndEmpty) {
  const auto map = RadarMap::FromBytes(SyntheticMap(0, 0).Bytes());
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_TRUE((*map)->Verify().ok());
  EXPECT_TRUE((*map)->KeyframesWithin(Eigen::Vector3d::Zero(), 1e9).empty());
  EXPECT_FALSE((*map)->NearestKeyframe(Eigen::Vector3d::Zero(), 1e9).has_value());
}

TEST(MapFileTest, EveryTruncationIsDataLoss) {
  const std::vector<std::byte> bytes = SyntheticMap(20, 15).Bytes();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto map =
        RadarMap::FromBytes({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    ASSERT_EQ(map.status().code(), absl::StatusCode::kDataLoss) << size;
  }
  std::vector<std::byte> longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_EQ(RadarMap::FromBytes(longer).status().code(), absl::StatusCode::kDataLoss);
}

TEST(MapFileTest, EveryFlippedByteIsDataLoss) {
  const std::vector<std::byte> bytes = SyntheticMap(20, 15).Bytes();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::vector<std::byte> flipped = bytes;
    flipped[i] ^= std::byte{0x10};
    const absl::Status status = Check(std::move(flipped));
    ASSERT_EQ(status.code(), absl::StatusCode::kDataLoss) << "byte " << i << ": " << status;
  }
}

// A fault under checksums that are right: only the check of the meaning can find it.
struct Fault {
  const char* message;
  std::function<void(SyntheticMap&)> make;
};

class MapFileFaultTest : public ::testing::TestWithParam<Fault> {};

TEST_P(MapFileFaultTest, IsDataLossThatSaysWhatIsWrong) {
  SyntheticMap map(20, 15);
  ASSERT_TRUE(Check(map.Bytes()).ok());
  GetParam().make(map);
  const absl::Status status = Check(map.Bytes());
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().message));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    All, MapFileFaultTest,
    ::testing::Values(
        Fault{"keyframe 3: first_point", [](SyntheticMap& m) { m.keyframes[3].first_point += 1; }},
        Fault{"keyframe 4: first_point", [](SyntheticMap& m) { m.keyframes[3].point_count = ~0U; }},
        Fault{"the keyframes hold", [](SyntheticMap& m) { m.keyframes[19].point_count += 1; }},
        Fault{"the keyframes hold", [](SyntheticMap& m) { m.points.pop_back(); }},
        Fault{"keyframe 2: its position",
              [](SyntheticMap& m) { m.keyframes[2].translation_local_m[1] = kNan; }},
        Fault{"keyframe 2: its position",
              [](SyntheticMap& m) { m.keyframes[2].translation_local_m[2] = 1e300; }},
        Fault{"keyframe 2: its rotation",
              [](SyntheticMap& m) { m.keyframes[2].rotation_wxyz[0] = kNan; }},
        Fault{"keyframe 2: its accuracy", [](SyntheticMap& m) { m.keyframes[2].accuracy = 1; }},
        Fault{"index record 5: keyframe is", [](SyntheticMap& m) { m.index[5].keyframe = 20; }},
        Fault{"index record 5: cell is", [](SyntheticMap& m) { m.index[5].cell_x += 1; }},
        Fault{"index record 6: out of order", [](SyntheticMap& m) { m.index[6] = m.index[5]; }},
        Fault{"index: 19 records", [](SyntheticMap& m) { m.index.pop_back(); }},
        Fault{"index_cell_m is nan", [](SyntheticMap& m) { m.info.index_cell_m = kNan; }},
        Fault{"length_m is -1", [](SyntheticMap& m) { m.info.length_m = -1.0; }},
        Fault{"local_origin_m", [](SyntheticMap& m) { m.info.local_origin_m[0] = kNan; }},
        Fault{"flags are 10", [](SyntheticMap& m) { m.info.flags = 16; }},
        Fault{"upper half must be a delay",
              [](SyntheticMap& m) { m.info.flags = 100U << kStampDelayShift; }},
        Fault{"upper half must be a delay",
              [](SyntheticMap& m) {
                m.info.flags = kHasKnownStampsFlag | 2000U << kStampDelayShift;
              }},
        Fault{"have no heights",
              [](SyntheticMap& m) { m.info.flags = kHasElevationFlag | kHasHeightsFlag; }},
        Fault{"anchor: latitude_deg is 91",
              [](SyntheticMap& m) {
                m.info.flags = kHasAnchorFlag;
                m.info.anchor_latitude_deg = 91.0;
              }},
        Fault{"name_size_bytes is 99", [](SyntheticMap& m) { m.info.name_size_bytes = 99; }},
        Fault{"the name has 6 bytes", [](SyntheticMap& m) { m.name = "spir\xC3\x28"; }},
        Fault{"the name has 6 bytes", [](SyntheticMap& m) { m.name = std::string("a\0bcde", 6); }},
        Fault{"the description has 5000", [](SyntheticMap& m) { m.description.assign(5000, 'a'); }},
        Fault{"point 7: a value is not finite",
              [](SyntheticMap& m) { m.points[7].rcs_dbsm = static_cast<float>(kNan); }},
        Fault{"point 7: its covariance", [](SyntheticMap& m) { m.points[7].xy_m2 = 0.1F; }},
        Fault{"point 7: its covariance", [](SyntheticMap& m) { m.points[7].zz_m2 = -1e-3F; }}));

}  // namespace
}  // namespace dcloc
