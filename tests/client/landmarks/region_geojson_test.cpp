#include "client/landmarks/region_geojson.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

const GeodeticAnchor kAnchor{.origin = {.latitude_deg = 48.0, .longitude_deg = 9.0},
                             .x_axis_east_rad = 0.5};

// A polygon's coordinates around these corners of the map frame.
std::string Coordinates(const std::vector<Eigen::Vector2d>& corners_m) {
  std::string text = "[[";
  for (const Eigen::Vector2d& corner : corners_m) {
    const GeodeticPosition p = GeodeticFromMap(kAnchor, {corner.x(), corner.y(), 0.0});
    absl::StrAppendFormat(&text, "%s[%.9f,%.9f]", text.size() > 2 ? "," : "", p.longitude_deg,
                          p.latitude_deg);
  }
  return text + "]]";
}

std::string Polygon(const std::string& coordinates) {
  return R"({"type":"Polygon","coordinates":)" + coordinates + "}";
}

const std::string kSquare = Coordinates({{10, 10}, {20, 10}, {20, 20}, {10, 20}, {10, 10}});

TEST(RegionGeoJsonTest, PolygonsLieWhereTheAnchorPutsThem) {
  const std::string feature =
      R"({"type":"Feature","properties":{},"geometry":)" + Polygon(kSquare) + "}";
  for (const std::string& text :
       {Polygon(kSquare), feature, R"({"type":"FeatureCollection","features":[)" + feature + "]}",
        R"({"type":"MultiPolygon","coordinates":[)" + kSquare + "]}",
        R"({"type":"GeometryCollection","geometries":[)" + Polygon(kSquare) + "]}"}) {
    const auto region = ParseRegionGeoJson(text, "r.geojson", kAnchor);
    ASSERT_TRUE(region.ok()) << region.status();
    EXPECT_TRUE(Contains(*region, {10.01, 19.99}));
    EXPECT_FALSE(Contains(*region, {9.99, 15.0}));
  }
}

// In the middle of 20 km a circle of latitude lies 9 m beside the straight line.
TEST(RegionGeoJsonTest, EdgesAreStraightInLongitudeAndLatitude) {
  for (const std::string corners :
       {"[8.866,48.0],[9.134,48.0],[9.134,48.05],[8.866,48.05],[8.866,48.0]",
        "[8.866,48.0],[8.866,48.05],[9.134,48.05],[9.134,48.0]"}) {
    const auto region = ParseRegionGeoJson(Polygon("[[" + corners + "]]"), "r.geojson", kAnchor);
    ASSERT_TRUE(region.ok()) << region.status();
    const auto holds = [&](double latitude_deg) {
      const GeodeticPosition p{.latitude_deg = latitude_deg, .longitude_deg = 9.0001};
      return Contains(*region, MapFromGeodetic(kAnchor, p).head<2>());
    };
    EXPECT_TRUE(holds(48.000005));
    EXPECT_FALSE(holds(47.999995));
    EXPECT_TRUE(holds(48.049995));
    EXPECT_FALSE(holds(48.050005));
    for (const auto& ring_m : region->polygons[0].rings_m) {
      for (std::size_t i = 1; i < ring_m.size(); ++i) {
        EXPECT_LE((ring_m[i] - ring_m[i - 1]).norm(), 500.0);
      }
    }
  }
}

TEST(RegionGeoJsonTest, WhatIsNoRegionIsRefused) {
  const auto error = [](const std::string& text) {
    return std::string(ParseRegionGeoJson(text, "r.geojson", kAnchor).status().message());
  };
  EXPECT_THAT(error("{"), HasSubstr("r.geojson: is no JSON"));
  EXPECT_THAT(error("[]"), HasSubstr("type is missing"));
  EXPECT_THAT(error(R"({"type":"Point","coordinates":[1,2]})"), HasSubstr("type is Point"));
  EXPECT_THAT(error(Polygon("[[[9,48],[9.1,48]]]")), HasSubstr("has 2 vertices"));
  EXPECT_THAT(error(Polygon("[[[9,95],[9.1,48],[9,48]]]")), HasSubstr("latitude_deg is 95"));
  EXPECT_THAT(error(Polygon("[[[9,48],[9.1,48],[9,53]]]")),
              HasSubstr("[9, 53] lies 556.0 km from the map's anchor; it must be at most 500 km"));
  EXPECT_THAT(error(Polygon("[[[9],[9.1,48],[9,48]]]")), HasSubstr("longitude and latitude"));
  EXPECT_THAT(error(R"({"type":"FeatureCollection","features":[]})"), HasSubstr("no polygon"));
  std::string deep = Polygon(kSquare);
  for (int i = 0; i < 20; ++i) deep = R"({"type":"Feature","geometry":)" + deep + "}";
  EXPECT_THAT(error(deep), HasSubstr("more than 8 deep"));
  const std::string brackets(100'000, '[');
  EXPECT_THAT(error(Polygon(brackets + std::string(100'000, ']'))),
              HasSubstr("r.geojson: is nested 100001 deep; it must be at most 32"));
  EXPECT_THAT(error(R"({"type":"\\\"[{)" + brackets + R"("})"), HasSubstr("type is \\\"[{"))
      << "brackets in a string are text";
}

}  // namespace
}  // namespace dcloc
