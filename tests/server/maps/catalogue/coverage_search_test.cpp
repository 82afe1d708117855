#include "server/maps/catalogue/coverage_search.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace dcloc::server {
namespace {

TEST(CoverageSearchTest, AVersionIsAsNearAsItsNearestBox) {
  NearestVersions nearest(100.0);
  nearest.Add("town", 2, 80.0);
  nearest.Add("town", 2, 30.0);
  nearest.Add("town", 1, 50.0);
  nearest.Add("far", 1, 100.1);
  std::vector<CoverageRecord> records = nearest.Records();
  ASSERT_EQ(records.size(), 2U);
  EXPECT_EQ(records[1].distance_m, 30.0);
  KeepNearest(1, &records);
  ASSERT_EQ(records.size(), 1U);
  EXPECT_EQ(records[0].version, 2);
}

TEST(CoverageSearchTest, EquallyNearOnesKeepTheirOrder) {
  std::vector<CoverageRecord> records = {{.map_name = "b", .distance_m = 1.0},
                                         {.map_name = "a", .distance_m = 1.0},
                                         {.map_name = "c", .distance_m = 0.0}};
  KeepNearest(10, &records);
  EXPECT_EQ(records[0].map_name + records[1].map_name + records[2].map_name, "cba");
}

/// Whether one of the windows around a place meets a box.
bool Meets(const GeodeticPosition& position, double radius_m, const Rectangle& box) {
  for (const EarthWindow& window : EarthWindows(position, radius_m)) {
    const Rectangle& reach = window.reach;
    if (reach.min_x <= box.max_x && box.min_x <= reach.max_x && reach.min_y <= box.max_y &&
        box.min_y <= reach.max_y) {
      return true;
    }
  }
  return false;
}

TEST(CoverageSearchTest, ABoxBeyondTheDateLineIsNear) {
  const GeodeticPosition west{.latitude_deg = 0.0, .longitude_deg = -179.9995};
  const Rectangle box{.min_x = 179.999, .max_x = 180.0002, .min_y = 0.0, .max_y = 0.001};
  EXPECT_TRUE(Meets(west, 200.0, box));
  const GeodeticPosition elsewhere{.latitude_deg = 0.0, .longitude_deg = 0.0};
  EXPECT_FALSE(Meets(elsewhere, 200.0, box));
}

TEST(CoverageSearchTest, ADegreeOfLongitudeIsHalfAsLongAt60Degrees) {
  const GeodeticPosition position{.latitude_deg = 60.0, .longitude_deg = 10.0};
  const EarthWindow window = EarthWindows(position, 1000.0)[1];
  const Rectangle east{.min_x = 10.01, .max_x = 10.02, .min_y = 60.0, .max_y = 60.0};
  EXPECT_NEAR(window.DistanceTo_m(east), 0.01 * 0.5 * 111'320.0, 1.0);
  EXPECT_TRUE(Meets(position, 1000.0, east));
  EXPECT_FALSE(Meets(position, 500.0, east));
}

}  // namespace
}  // namespace dcloc::server
