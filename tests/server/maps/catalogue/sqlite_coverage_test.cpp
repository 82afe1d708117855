#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/base/sqlite.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/maps/store/map_store_fixture.h"

// Which versions cover a place, in metres and in degrees.
namespace dcloc::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

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
DROP TABLE loose_file; DROP TABLE coverage_box; DROP TABLE coverage_map; DROP TABLE coverage_earth;
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

TEST_F(CoverageStoreTest, AnEntryThatAFailureLeftInTheTreeIsInNobodysWay) {
  Put(StraightStreet(5).Bytes());
  {
    absl::StatusOr<SqliteDatabase> database =
        SqliteDatabase::Open(folder_.path() / "catalogue.sqlite");
    const absl::Status status = database->Run(
        "INSERT INTO coverage_map SELECT MAX(id) + 1, 0, 1, 9000, 9001 FROM coverage_box");
    ASSERT_TRUE(status.ok()) << status;
  }
  EXPECT_THAT(NearPlace(0.5, 9000.5, 5.0), IsEmpty());
  EXPECT_EQ(Put(StraightStreet(20).Bytes()), 2);
  EXPECT_EQ(NearPlace(150.0, 0.0, 5.0).size(), 1U);
  EXPECT_THAT(NearPlace(0.5, 9000.5, 5.0), IsEmpty());
}

TEST_F(CoverageStoreTest, ACatalogueOfTheFirstVersionIsBroughtUpToDate) {
  Put(StraightStreet(20).Bytes());
  Close();
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

}  // namespace
}  // namespace dcloc::server
