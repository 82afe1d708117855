#include "client/evaluation/faults/map_faults.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

constexpr std::size_t kKeyframes = 8;

/// On the way of which are the first keyframes of a made map.
Stream StreamInMap() {
  Stream stream = MadeStream(8.0);
  stream.map = MadeMap(kKeyframes);
  return stream;
}

TEST(MapFaultsTest, LandmarksWithinTheWindowAreThoseOfHalfAMapOnMirrored) {
  Stream stream = StreamInMap();
  ReplaceLandmarks(stream, {MadeStamp(1.5), MadeStamp(3.5)}, 1.0, 1);
  for (std::size_t i = 0; i < kKeyframes; ++i) {
    const Keyframe keyframe = stream.map->keyframe(i);
    const bool is_changed = i == 2 || i == 3;
    ASSERT_EQ(keyframe.points.size(), kMadeLandmarks) << i;
    for (const MapPoint& point : keyframe.points) {
      EXPECT_EQ(point.x_m, static_cast<float>(is_changed ? i + 4 : i));
      EXPECT_EQ(point.y_m < 0, is_changed);
      EXPECT_EQ(point.xy_m2, is_changed ? -0.5F : 0.5F);
    }
  }
}

TEST(MapFaultsTest, AShareOfThemStaysAndTheOthersComeFromElsewhere) {
  Stream stream = StreamInMap();
  ReplaceLandmarks(stream, {Stamp::min()}, 0.5, 1);
  const Keyframe keyframe = stream.map->keyframe(1);
  const auto own = std::ranges::count(keyframe.points, 1.0F, &MapPoint::x_m);
  const auto foreign = std::ranges::count(keyframe.points, 5.0F, &MapPoint::x_m);
  EXPECT_NEAR(static_cast<double>(own), 50.0, 20.0);
  EXPECT_NEAR(static_cast<double>(foreign), 50.0, 20.0);
  EXPECT_EQ(static_cast<std::size_t>(own + foreign), keyframe.points.size());
}

TEST(MapFaultsTest, AGapIsWhereTheWindowIsDriven) {
  Stream stream = StreamInMap();
  RemoveStreet(stream, {MadeStamp(1.5), MadeStamp(3.5)});
  ASSERT_EQ(stream.map->info().keyframe_count, kKeyframes - 2);
  for (std::size_t i = 0; i < kKeyframes - 2; ++i) {
    const double x_m = stream.map->keyframe(i).points.front().x_m;
    EXPECT_EQ(x_m, static_cast<double>(i < 2 ? i : i + 2));
  }
}

}  // namespace
}  // namespace dcloc::faults
