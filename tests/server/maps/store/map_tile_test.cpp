#include "server/maps/store/map_tile.h"

#include <gtest/gtest.h>

#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {
namespace {

TEST(MapTileTest, HoldsWhatLiesInTheRectangle) {
  const auto map = *RadarMap::FromBytes(StraightStreet(20).Bytes());
  const Rectangle bounds{.min_x = 40.0, .max_x = 100.0, .min_y = -10.0, .max_y = 7.0};
  const MapTile tile = ReadTile(*map, bounds, 100'000, 1000);
  std::int64_t expected = 0;
  for (std::size_t i = 0; i < 20; ++i) {
    const Keyframe keyframe = map->keyframe(i);
    for (const MapPoint& point : keyframe.points) {
      const double x_m = keyframe.T_map_keyframe.translation_m.x() + point.x_m;
      expected += x_m >= 40.0 && x_m <= 100.0 && point.y_m <= 7.0F ? 1 : 0;
    }
  }
  EXPECT_GT(expected, 50);
  EXPECT_EQ(tile.point_count, expected);
  EXPECT_EQ(tile.points.size(), static_cast<std::size_t>(expected));
  EXPECT_EQ(tile.keyframes.size(), 7U);  // 40, 50, ... 100
  EXPECT_EQ(tile.origin_map_m, Eigen::Vector3d(40.0, -10.0, 0.0));
  for (const TilePoint& point : tile.points) {
    EXPECT_GE(point.p_tile_m.x(), 0.0F);
    EXPECT_LE(point.p_tile_m.x(), 60.0F);
    EXPECT_NEAR(point.p_tile_m.z(), 0.5F, 1e-6);
    EXPECT_EQ(point.rcs_dbsm, 3.0F);
  }
}

TEST(MapTileTest, TakesEvenlyOfTooMuch) {
  const auto map = *RadarMap::FromBytes(StraightStreet(20).Bytes());
  const Rectangle everything{.min_x = -500.0, .max_x = 500.0, .min_y = -500.0, .max_y = 500.0};
  const MapTile tile = ReadTile(*map, everything, 150, 7);
  EXPECT_EQ(tile.point_count, 400);
  EXPECT_LE(tile.points.size(), 150U);
  EXPECT_GT(tile.points.size(), 75U);
  EXPECT_GT(tile.points.back().p_tile_m.x() - tile.points.front().p_tile_m.x(), 150.0F);
  EXPECT_LE(tile.keyframes.size(), 7U);
  const Rectangle nowhere{.min_x = 9000.0, .max_x = 9001.0, .min_y = 0.0, .max_y = 1.0};
  EXPECT_EQ(ReadTile(*map, nowhere, 150, 7).point_count, 0);
}

}  // namespace
}  // namespace dcloc::server
