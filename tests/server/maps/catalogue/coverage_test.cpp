#include "server/maps/catalogue/coverage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {
namespace {

TEST(CoverageTest, BoxesHoldEachKeyframeAndAreSmall) {
  const auto map = *RadarMap::FromBytes(SmallMap("spiral", 500));
  const std::vector<CoverageBox> boxes = CoverageOf(*map);
  EXPECT_GT(boxes.size(), 100U);
  for (const CoverageBox& box : boxes) {
    EXPECT_LE(box.map_m.max_x - box.map_m.min_x, 75.0);
    EXPECT_LE(box.map_m.max_y - box.map_m.min_y, 75.0);
    EXPECT_FALSE(box.degrees.has_value());
  }
  for (std::size_t i = 0; i < map->info().keyframe_count; ++i) {
    const Eigen::Vector3d p_map = map->keyframe(i).T_map_keyframe.translation_m;
    EXPECT_TRUE(std::ranges::any_of(boxes, [&](const CoverageBox& box) {
      return DistanceTo(box.map_m, p_map.x(), p_map.y()) == 0.0;
    }));
  }
}

TEST(CoverageTest, TheStreetBetweenKeyframesIsCoveredButNoGapOfTheDrive) {
  SyntheticMap street = StraightStreet(20);
  for (std::size_t i = 10; i < 20; ++i) street.keyframes[i].translation_local_m[0] += 50.0;
  street.index = MakeIndex(street.keyframes, street.info.index_cell_m);
  const std::vector<CoverageBox> boxes = CoverageOf(**RadarMap::FromBytes(street.Bytes()));
  const auto covered = [&](double x_m) {
    return std::ranges::any_of(
        boxes, [&](const CoverageBox& box) { return DistanceTo(box.map_m, x_m, 0.0) == 0.0; });
  };
  for (int i = 0; i <= 180; ++i) EXPECT_TRUE(covered(0.5 * i)) << i;
  for (int i = 181; i < 300; ++i) EXPECT_FALSE(covered(0.5 * i)) << i;
  EXPECT_TRUE(covered(150.0));
}

}  // namespace
}  // namespace dcloc::server
