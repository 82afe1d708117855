#include "server/convert/map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

v1::ReadMapTileRequest TileRequest(double width_m) {
  v1::ReadMapTileRequest request;
  request.set_min_x_m(-10.0);
  request.set_max_x_m(-10.0 + width_m);
  request.set_min_y_m(0.0);
  request.set_max_y_m(1.0);
  return request;
}

TEST(ConvertMapTest, ATenantSeesItsMapsByTheirOwnNames) {
  MapRecord record;
  record.name = "acme/town";
  record.active_version = 3;
  record.canary_share = 0.25;
  v1::Map map;
  convert::ToProto(record, &map);
  EXPECT_EQ(map.name(), "town");
  EXPECT_EQ(map.active_version(), 3);
  EXPECT_EQ(map.canary_share(), 0.25);
  v1::MapCoverage coverage;
  convert::ToProto(CoverageRecord{.map_name = "acme/town", .version = 2, .distance_m = 7.5},
                   &coverage);
  EXPECT_EQ(coverage.map_name(), "town");
  EXPECT_EQ(coverage.distance_m(), 7.5);
}

TEST(ConvertMapTest, AMapWithoutAnchorIsToldWithoutOne) {
  MapVersionRecord record;
  record.map_name = "town";
  record.info.point_count = 7;
  v1::MapVersion version;
  convert::ToProto(record, &version);
  EXPECT_EQ(version.info().point_count(), 7);
  EXPECT_FALSE(version.info().has_anchor());
  record.info.anchor = GeodeticAnchor{.origin = {.latitude_deg = 52.0}};
  convert::ToProto(record, &version);
  EXPECT_EQ(version.info().anchor().origin().latitude_deg(), 52.0);
}

TEST(ConvertMapTest, ATileIsABoundedRectangle) {
  const auto tile = convert::FromProto(TileRequest(20.0));
  ASSERT_TRUE(tile.ok()) << tile.status();
  EXPECT_EQ(tile->bounds_m.max_x, 10.0);
  EXPECT_EQ(tile->max_point_count, 20'000U);  // where the request names no count
  for (const double width_m : {-1.0, 5'001.0}) {
    EXPECT_THAT(MessageOf(convert::FromProto(TileRequest(width_m)).status()), HasSubstr("max_x_m"));
  }
  v1::ReadMapTileRequest many = TileRequest(20.0);
  many.set_max_point_count(50'001);
  EXPECT_THAT(MessageOf(convert::FromProto(many).status()), HasSubstr("max_point_count"));
}

TEST(ConvertMapTest, CoverageIsAskedForAtOneKindOfPlace) {
  v1::FindCoverageRequest request;
  request.set_radius_m(100.0);
  EXPECT_THAT(MessageOf(convert::FromProto(request).status()), HasSubstr("place"));
  request.mutable_map_place()->set_map_name("town");
  request.mutable_map_place()->set_x_m(1e9);
  EXPECT_THAT(MessageOf(convert::FromProto(request).status()), HasSubstr("map_place.x_m"));
  request.mutable_map_place()->set_x_m(5.0);
  const auto query = convert::FromProto(request);
  ASSERT_TRUE(query.ok()) << query.status();
  EXPECT_EQ(std::get<convert::MapPlace>(query->place).p_map.x(), 5.0);
  request.set_radius_m(10'001.0);
  EXPECT_THAT(MessageOf(convert::FromProto(request).status()), HasSubstr("radius_m"));
}

TEST(ConvertMapTest, ACanaryHasAShareAndNoCanaryHasNone) {
  v1::SetMapCanaryRequest request;
  request.set_map_name("town");
  EXPECT_TRUE(convert::Check(request).ok());
  request.set_share(0.1);
  EXPECT_THAT(MessageOf(convert::Check(request)), HasSubstr("share"));
  request.set_version(2);
  EXPECT_TRUE(convert::Check(request).ok());
  request.set_share(0.0);
  EXPECT_THAT(MessageOf(convert::Check(request)), HasSubstr("share"));
}

}  // namespace
}  // namespace dcloc::server
