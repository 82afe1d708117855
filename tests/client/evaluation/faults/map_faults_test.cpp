#include "client/evaluation/faults/map_faults.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/map/editable_map.h"
#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

constexpr int kKeyframes = 8;
constexpr float kPointsEach = 100;

/// Keyframes every 10 m along the way of a made stream. Each has landmarks with its own number as
/// their distance ahead, all to the left.
std::shared_ptr<const RadarMap> NumberedMap() {
  EditableMap map;
  map.name = "made";
  map.info.length_m = 80.0;
  map.info.index_cell_m = 25.0;
  for (int i = 0; i < kKeyframes; ++i) {
    EditableKeyframe& keyframe = map.keyframes.emplace_back();
    keyframe.record.translation_local_m[0] = 10.0 * i;
    keyframe.record.rotation_wxyz[0] = 1.0;
    for (float y = 1; y <= kPointsEach; ++y) {
      keyframe.points.push_back({.x_m = static_cast<float>(i),
                                 .y_m = y,
                                 .xx_m2 = 1,
                                 .xy_m2 = 0.5,
                                 .yy_m2 = 1,
                                 .zz_m2 = 1,
                                 .scan_count = 1,
                                 .pass_count = 1});
    }
  }
  return *RadarMap::FromBytes(*ToMapBytes(map));
}

Stream StreamInNumberedMap() {
  Stream stream = MadeStream(8.0);
  stream.map = NumberedMap();
  return stream;
}

TEST(MapFaultsTest, LandmarksWithinTheWindowAreThoseOfHalfAMapOnMirrored) {
  Stream stream = StreamInNumberedMap();
  ReplaceLandmarks(stream, {MadeStamp(1.5), MadeStamp(3.5)}, 1.0, 1);
  for (std::size_t i = 0; i < kKeyframes; ++i) {
    const Keyframe keyframe = stream.map->keyframe(i);
    const bool is_changed = i == 2 || i == 3;
    ASSERT_EQ(keyframe.points.size(), kPointsEach) << i;
    for (const MapPoint& point : keyframe.points) {
      EXPECT_EQ(point.x_m, static_cast<float>(is_changed ? i + 4 : i));
      EXPECT_EQ(point.y_m < 0, is_changed);
      EXPECT_EQ(point.xy_m2, is_changed ? -0.5F : 0.5F);
    }
  }
}

TEST(MapFaultsTest, AShareOfThemStaysAndTheOthersComeFromElsewhere) {
  Stream stream = StreamInNumberedMap();
  ReplaceLandmarks(stream, {Stamp::min()}, 0.5, 1);
  const Keyframe keyframe = stream.map->keyframe(1);
  const auto own = std::ranges::count(keyframe.points, 1.0F, &MapPoint::x_m);
  const auto foreign = std::ranges::count(keyframe.points, 5.0F, &MapPoint::x_m);
  EXPECT_NEAR(static_cast<double>(own), 50.0, 20.0);
  EXPECT_NEAR(static_cast<double>(foreign), 50.0, 20.0);
  EXPECT_EQ(static_cast<std::size_t>(own + foreign), keyframe.points.size());
}

}  // namespace
}  // namespace dcloc::faults
