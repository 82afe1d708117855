#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "server/base/sqlite.h"
#include "server/maps/catalogue/coverage.h"
#include "server/maps/store/map_tile.h"
#include "tests/server/maps/store/map_store_fixture.h"

// What lies where: coverage, in metres and in degrees, and tiles.
namespace dcloc::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Keyframes on a line along x, 10 m apart from x = 0 on.
SyntheticMap StraightStreet(std::size_t keyframe_count) {
  SyntheticMap map(keyframe_count, 20);
  for (std::size_t i = 0; i < keyframe_count; ++i) {
    map.keyframes[i].translation_local_m = {10.0 * static_cast<double>(i), 0.0, 0.0};
    map.keyframes[i].rotation_wxyz = {1.0, 0.0, 0.0, 0.0};
  }
  map.info.local_origin_m = {0.0, 0.0, 0.0};
  map.index = MakeIndex(map.keyframes, map.info.index_cell_m);
  return map;
}

std::vector<std::byte> AnchoredStreet(double latitude_deg, double longitude_deg) {
  SyntheticMap map = StraightStreet(20);
  map.info.flags |= kHasAnchorFlag;
  map.info.anchor_latitude_deg = latitude_deg;
  map.info.anchor_longitude_deg = longitude_deg;
  return map.Bytes();
}

std::shared_ptr<const RadarMap> Loaded(const std::vector<std::byte>& bytes) {
  return *RadarMap::FromBytes(bytes);
}

TEST(CoverageTest, BoxesHoldEachKeyframeAndAreSmall) {
  const auto map = Loaded(SmallMap("spiral", 500));
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
  const std::vector<CoverageBox> boxes = CoverageOf(*Loaded(street.Bytes()));
  const auto covered = [&](double x_m) {
    return std::ranges::any_of(
        boxes, [&](const CoverageBox& box) { return DistanceTo(box.map_m, x_m, 0.0) == 0.0; });
  };
  for (int i = 0; i <= 180; ++i) EXPECT_TRUE(covered(0.5 * i)) << i;
  for (int i = 181; i < 300; ++i) EXPECT_FALSE(covered(0.5 * i)) << i;
  EXPECT_TRUE(covered(150.0));
}

class CoverageStoreTest : public StoreFixture {
 protected:
  std::vector<std::string> Near(double latitude_deg, double longitude_deg, double radius_m,
                                const std::string& prefix = "") {
    std::vector<std::string> names;
    const auto records = store_->catalogue().FindCoverage(
        prefix, {.latitude_deg = latitude_deg, .longitude_deg = longitude_deg}, radius_m, 10);
    EXPECT_TRUE(records.ok()) << records.status();
    for (const CoverageRecord& record : *records) names.push_back(record.map_name);
    return names;
  }

  std::vector<CoverageRecord> NearPlace(double x_m, double y_m, double radius_m) {
    return *store_->catalogue().FindCoverage("town", Eigen::Vector2d(x_m, y_m), radius_m);
  }

  void PutAs(const std::string& tenant, const std::string& map_name,
             const std::vector<std::byte>& bytes) {
    UploadRequest request = RequestFor(bytes);
    request.tenant = tenant;
    request.map_name = map_name;
    absl::StatusOr<Upload> upload = Upload::Begin(*store_, request, kNoLimits);
    ASSERT_TRUE(AppendAll(*upload, bytes).ok());
    ASSERT_TRUE(upload->Finish().ok());
  }
};

TEST_F(CoverageStoreTest, ThePlaceInAMapIsFoundByItsDistance) {
  Put(StraightStreet(20).Bytes());
  ASSERT_EQ(NearPlace(95.0, 3.0, 5.0).size(), 1U);
  EXPECT_NEAR(NearPlace(95.0, 3.0, 5.0)[0].distance_m, 3.0, 1e-9);
  EXPECT_THAT(NearPlace(95.0, 30.0, 20.0), IsEmpty());
  EXPECT_NEAR(NearPlace(190.0 + 30.0, 40.0, 60.0).at(0).distance_m, 50.0, 1e-9);
  EXPECT_THAT(NearPlace(190.0 + 30.0, 40.0, 49.999), IsEmpty());
  EXPECT_EQ(store_->catalogue().FindCoverage("city", Eigen::Vector2d(0, 0), 1.0).status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(CoverageStoreTest, FarFromTheOriginNoMetreIsLost) {
  SyntheticMap map = StraightStreet(3);
  map.info.local_origin_m = {500'000.0, 5'400'000.0, 0.0};
  Put(map.Bytes());
  EXPECT_NEAR(NearPlace(500'010.0, 5'400'000.3, 1.0).at(0).distance_m, 0.3, 1e-6);
  EXPECT_THAT(NearPlace(500'010.0, 5'400'000.3, 0.299), IsEmpty());
}

TEST_F(CoverageStoreTest, OnlyTheActiveVersionCovers) {
  Put(StraightStreet(5).Bytes());
  Put(StraightStreet(20).Bytes(), /*activate=*/false);
  EXPECT_THAT(NearPlace(150.0, 0.0, 5.0), IsEmpty());
  ASSERT_TRUE(store_->Activate("town", 2).ok());
  EXPECT_EQ(NearPlace(150.0, 0.0, 5.0).at(0).version, 2);
  ASSERT_TRUE(store_->DeleteVersion("town", 1).ok());
  EXPECT_EQ(NearPlace(10.0, 0.0, 5.0).size(), 1U);
}

TEST_F(CoverageStoreTest, PlacesOnTheEarthFindAnchoredMapsNearestFirst) {
  PutAs("", "town", AnchoredStreet(52.5, 13.25));
  PutAs("", "city", AnchoredStreet(52.501, 13.25));
  PutAs("", "lost", StraightStreet(20).Bytes());
  PutAs("acme", "town", AnchoredStreet(52.5, 13.25));
  const double metre_deg = 1.0 / 111'000.0;
  EXPECT_THAT(Near(52.5, 13.25, 1.0), ElementsAre("town"));
  EXPECT_THAT(Near(52.5 + 100 * metre_deg, 13.25, 200.0), ElementsAre("city", "town"));
  EXPECT_THAT(Near(52.5 - 10 * metre_deg, 13.25, 11.0), ElementsAre("town"));
  EXPECT_THAT(Near(52.5 - 10 * metre_deg, 13.25, 9.0), IsEmpty());
  EXPECT_THAT(Near(52.5, 13.25, 1.0, "acme/"), ElementsAre("acme/town"));
  // 190 m to the east the street ends; a degree of longitude is shorter up here.
  const double east_deg = 200.0 * metre_deg / std::cos(52.5 * M_PI / 180.0);
  EXPECT_THAT(Near(52.5, 13.25 + east_deg, 12.0), ElementsAre("town"));
  EXPECT_THAT(Near(52.5, 13.25 + east_deg, 7.0), IsEmpty());
  ASSERT_TRUE(store_->DeleteMap("town").ok());
  EXPECT_THAT(Near(52.5, 13.25, 1.0), IsEmpty()) << "coverage goes with its version";
}

TEST_F(CoverageStoreTest, TheDateLineIsNoEdge) {
  PutAs("", "fiji", AnchoredStreet(-17.0, 179.9995));  // 190 m of street, across it
  EXPECT_THAT(Near(-17.0, 179.9996, 1.0), ElementsAre("fiji"));
  EXPECT_THAT(Near(-17.0, -179.999, 5.0), ElementsAre("fiji"));
  EXPECT_THAT(Near(-17.0, -179.99, 5.0), IsEmpty());
}

TEST_F(CoverageStoreTest, PolesAreNoError) {
  PutAs("", "pole", AnchoredStreet(89.9999, 0.0));
  EXPECT_THAT(Near(90.0, 0.0, 100.0), ElementsAre("pole"));
}

/// What the catalogue was in its first version.
constexpr char kFirstVersion[] = R"(
DROP TRIGGER coverage_box_insert; DROP TRIGGER coverage_box_delete;
DROP TABLE coverage_box; DROP TABLE coverage_map; DROP TABLE coverage_earth;
DROP VIEW map_row; DROP VIEW map_version_row;
ALTER TABLE map DROP COLUMN previous_version;
ALTER TABLE map DROP COLUMN canary_version;
ALTER TABLE map DROP COLUMN canary_share;
CREATE VIEW map_row AS
  SELECT name, active_version,
         (SELECT COUNT(*) FROM map_version WHERE map_name = name) AS version_count, create_time_ns
  FROM map;
CREATE VIEW map_version_row AS
  SELECT map_version.*, active_version = version AS active
  FROM map_version JOIN map ON map_name = name;
PRAGMA user_version = 1;
)";

TEST_F(CoverageStoreTest, ACatalogueOfTheFirstVersionIsBroughtUpToDate) {
  Put(StraightStreet(20).Bytes());
  store_.reset();
  {
    absl::StatusOr<SqliteDatabase> database =
        SqliteDatabase::Open(folder_.path() / "catalogue.sqlite");
    const absl::Status status = database->Run(kFirstVersion);
    ASSERT_TRUE(status.ok()) << status;
  }
  Reopen();
  EXPECT_EQ(store_->report().covered_version_count, 1);
  EXPECT_EQ(NearPlace(95.0, 3.0, 5.0).size(), 1U);
  EXPECT_EQ(Town().active_version, 1);
  EXPECT_EQ(Town().previous_version, 0);
  EXPECT_EQ(Put(SmallMap()), 2);
  Reopen();
  EXPECT_EQ(store_->report().covered_version_count, 0);
}

TEST(MapTileTest, HoldsWhatLiesInTheRectangle) {
  const auto map = Loaded(StraightStreet(20).Bytes());
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
  EXPECT_EQ(tile.keyframes_tile_m.size(), 7U);  // 40, 50, ... 100
  EXPECT_EQ(tile.origin_map_m, Eigen::Vector3d(40.0, -10.0, 0.0));
  for (const TilePoint& point : tile.points) {
    EXPECT_GE(point.p_tile_m.x(), 0.0F);
    EXPECT_LE(point.p_tile_m.x(), 60.0F);
    EXPECT_NEAR(point.p_tile_m.z(), 0.5F, 1e-6);
    EXPECT_EQ(point.rcs_dbsm, 3.0F);
  }
}

TEST(MapTileTest, TakesEvenlyOfTooMuch) {
  const auto map = Loaded(StraightStreet(20).Bytes());
  const Rectangle everything{.min_x = -500.0, .max_x = 500.0, .min_y = -500.0, .max_y = 500.0};
  const MapTile tile = ReadTile(*map, everything, 150, 7);
  EXPECT_EQ(tile.point_count, 400);
  EXPECT_LE(tile.points.size(), 150U);
  EXPECT_GT(tile.points.size(), 75U);
  EXPECT_GT(tile.points.back().p_tile_m.x() - tile.points.front().p_tile_m.x(), 150.0F);
  EXPECT_LE(tile.keyframes_tile_m.size(), 7U);
  const Rectangle nowhere{.min_x = 9000.0, .max_x = 9001.0, .min_y = 0.0, .max_y = 1.0};
  EXPECT_EQ(ReadTile(*map, nowhere, 150, 7).point_count, 0);
}

}  // namespace
}  // namespace dcloc::server
