// Landmarks and keyframes as files of other tools, and back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client/landmarks/keyframe_trajectory.h"
#include "client/landmarks/landmark_geojson.h"
#include "client/landmarks/landmark_pcd.h"
#include "client/trajectory/trajectory_reader.h"
#include "client/trajectory/trajectory_writer.h"
#include "tests/core/map/synthetic_map.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using Rows = std::vector<LandmarkRow>;

// 12 keyframes at UTM-like coordinates, or near an anchor; points with odd bits.
EditableMap Town(bool is_anchored) {
  SyntheticMap synthetic(12, 9);
  for (std::size_t i = 0; i < synthetic.points.size(); ++i) {
    synthetic.points[i].x_m += 0.1F * static_cast<float>(i) / 3.0F;
    synthetic.points[i].rcs_dbsm = -7.0F / static_cast<float>(i + 1);
    synthetic.points[i].scan_count = static_cast<std::uint16_t>(65535 - i);
  }
  if (is_anchored) {
    synthetic.info.local_origin_m = {1234.5, -3456.7, 8.9};
    synthetic.info.flags = kHasAnchorFlag;
    synthetic.info.anchor_latitude_deg = -33.0;
    synthetic.info.anchor_longitude_deg = 151.0;
    synthetic.info.anchor_x_axis_east_rad = 2.0;
  }
  auto map = RadarMap::FromBytes(synthetic.Bytes());
  EXPECT_TRUE(map.ok()) << map.status();
  return ToEditable(**map);
}

Rows Read(const absl::StatusOr<Rows>& rows) {
  EXPECT_TRUE(rows.ok()) << rows.status();
  return rows.ok() ? *rows : Rows();
}

std::vector<std::byte> BytesOf(const absl::StatusOr<EditableMap>& map) {
  EXPECT_TRUE(map.ok()) << map.status();
  auto bytes = ToMapBytes(*map);
  EXPECT_TRUE(bytes.ok()) << bytes.status();
  return *std::move(bytes);
}

Rows FromGeoJson(const EditableMap& map, const std::string& text) {
  return Read(ParseLandmarkGeoJson(text, "town.geojson", *map.Anchor()));
}

TEST(ExchangeTest, UnchangedFilesGiveTheSameMap) {
  const EditableMap town = Town(false);
  LandmarkEdits counts;
  EXPECT_EQ(BytesOf(ReplaceLandmarks(
                town, Read(ParseLandmarkPcd(FormatLandmarkPcd(town), "town.pcd", town.Origin_m())),
                counts)),
            BytesOf(town));
  EXPECT_EQ(counts.same, town.PointCount());
  const EditableMap anchored = Town(true);
  EXPECT_EQ(BytesOf(ReplaceLandmarks(
                anchored, FromGeoJson(anchored, *FormatLandmarkGeoJson(anchored)), counts)),
            BytesOf(anchored));
  EXPECT_EQ(counts.same, town.PointCount());
  EXPECT_EQ(counts.removed + counts.added + counts.moved + counts.edited, 0U);
}

TEST(ExchangeTest, UnchangedKeyframesGiveTheSameMap) {
  const EditableMap town = Town(false);
  for (const TrajectoryFormat format : {TrajectoryFormat::kTum, TrajectoryFormat::kCsv}) {
    const auto text = FormatTrajectory(KeyframeTrajectory(town), format);
    ASSERT_TRUE(text.ok());
    std::size_t moved_count = 99;
    EXPECT_EQ(BytesOf(MoveKeyframes(town, *ParseTrajectory(*text, format, "town"), moved_count)),
              BytesOf(town));
    EXPECT_EQ(moved_count, 0U);
  }
}

TEST(ExchangeTest, AMovedKeyframeTakesItsLandmarksAlong) {
  const EditableMap town = Town(false);
  Trajectory trajectory = KeyframeTrajectory(town);
  trajectory.poses[4].T_map_vehicle.translation_m.x() += 2.0;
  std::size_t moved_count = 0;
  const auto moved = MoveKeyframes(town, trajectory, moved_count);
  ASSERT_TRUE(moved.ok()) << moved.status();
  EXPECT_EQ(moved_count, 1U);
  const Rows before = RowsOf(town);
  const Rows after = RowsOf(*moved);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double way_m = before[i].keyframe == 4U ? 2.0 : 0.0;
    EXPECT_NEAR(after[i].p_map.x() - before[i].p_map.x(), way_m, 1e-6);
  }
  trajectory.poses.pop_back();
  EXPECT_THAT(MoveKeyframes(town, trajectory, moved_count).status().message(),
              HasSubstr("has 11 poses; it must have one for each of the 12 keyframes"));
}

TEST(ExchangeTest, MendedLandmarksAreCounted) {
  const EditableMap town = Town(true);
  Rows rows = FromGeoJson(town, *FormatLandmarkGeoJson(town));
  rows.erase(rows.begin());                       // removed
  rows[0].p_map.x() += 0.004;                     // another tool's rounding
  rows[1].p_map += Eigen::Vector3d(3.0, 1.0, 0);  // moved
  rows[2].point.rcs_dbsm = 20.0F;                 // edited
  rows.push_back(rows[5]);                        // copied
  rows.back().p_map.y() += 1.0;
  LandmarkEdits counts;
  const auto mended = ReplaceLandmarks(town, rows, counts);
  ASSERT_TRUE(mended.ok()) << mended.status();
  EXPECT_EQ(counts.removed, 1U);
  EXPECT_EQ(counts.moved, 1U);
  EXPECT_EQ(counts.edited, 1U);
  EXPECT_EQ(counts.added, 1U);
  EXPECT_EQ(counts.same, town.PointCount() - 3);
  const Rows found = RowsOf(*mended);
  EXPECT_LT((found[1].p_map - rows[1].p_map).norm(), 1e-5);
}

TEST(ExchangeTest, ALandmarkThatWasDrawnAnewJoinsTheNearestKeyframe) {
  const EditableMap town = Town(true);
  Rows rows = RowsOf(town);
  LandmarkRow drawn = rows[40];
  drawn.keyframe.reset();
  drawn.p_map.z() += 0.5;
  drawn.point.xx_m2 = 0.09F;
  drawn.point.xy_m2 = 0.0F;
  drawn.point.yy_m2 = 0.01F;
  rows.push_back(drawn);
  LandmarkEdits counts;
  const auto mended = ReplaceLandmarks(town, rows, counts);
  ASSERT_TRUE(mended.ok()) << mended.status();
  EXPECT_EQ(counts.added, 1U);
  bool found = false;
  for (const LandmarkRow& row : RowsOf(*mended)) {
    found = found || (row.p_map - drawn.p_map).norm() < 1e-5;
  }
  EXPECT_TRUE(found);
  rows.back().p_map.x() += 5000.0;
  rows.back().name = "town.pcd: point 108";
  EXPECT_THAT(ReplaceLandmarks(town, rows, counts).status().message(),
              HasSubstr("town.pcd: point 108: it lies at"));
}

TEST(ExchangeTest, ToolsOfThePlaneMayLeaveTheHeightOut) {
  EditableMap town = Town(true);
  town.info.local_origin_m[2] = 300.0;  // where 4 km from the anchor the vertical is 0.2 m off
  std::string text = *FormatLandmarkGeoJson(town);
  for (std::size_t i = 0; (i = text.find("\"coordinates\":[", i)) != std::string::npos; ++i) {
    const std::size_t end = text.find(']', i);
    const std::size_t comma = text.rfind(',', end);
    text.erase(comma, end - comma);
  }
  ASSERT_FALSE(FromGeoJson(town, text)[0].has_height);
  LandmarkEdits counts;
  EXPECT_EQ(BytesOf(ReplaceLandmarks(town, FromGeoJson(town, text), counts)), BytesOf(town));
  EXPECT_EQ(counts.same, town.PointCount());
}

TEST(ExchangeTest, AMoveInThePlaneLeavesTheHeight) {
  EditableMap town = Town(true);
  town.info.local_origin_m[2] = 300.0;
  Rows rows = RowsOf(town);
  const GeodeticPosition before = GeodeticFromMap(*town.Anchor(), rows[3].p_map);
  GeodeticPosition moved = before;
  moved.latitude_deg += 1e-5;
  moved.height_m = 0.0;
  rows[3].p_map = MapFromGeodetic(*town.Anchor(), moved);
  rows[3].has_height = false;
  LandmarkEdits counts;
  const auto mended = ReplaceLandmarks(town, rows, counts);
  ASSERT_TRUE(mended.ok()) << mended.status();
  EXPECT_EQ(counts.moved, 1U);
  const GeodeticPosition after = GeodeticFromMap(*town.Anchor(), RowsOf(*mended)[3].p_map);
  EXPECT_NEAR(after.latitude_deg, moved.latitude_deg, 1e-9);
  EXPECT_NEAR(after.longitude_deg, before.longitude_deg, 1e-9);
  EXPECT_NEAR(after.height_m, before.height_m, 1e-4);
}

TEST(ExchangeTest, AsciiFromAnotherToolIsRead) {
  const std::string text =
      "# x\r\nVERSION .7\r\nFIELDS y x z xx_m2 xy_m2 xz_m2 yy_m2 yz_m2 zz_m2 rcs_dbsm scan_count "
      "pass_count\nSIZE 8 4 4 4 4 4 4 4 4 4 4 4\nTYPE F F F F F F F F F F F F\nWIDTH 1\nHEIGHT 1\n"
      "POINTS 1\nDATA ascii\n2.5 1.5 0.25 .1 0 0 .2 0 .3 4 7 1\n";
  const Rows rows = Read(ParseLandmarkPcd(text, "a.pcd", {100, 200, 0}));
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].p_map, Eigen::Vector3d(101.5, 202.5, 0.25));
  EXPECT_FALSE(rows[0].keyframe.has_value());
  EXPECT_EQ(rows[0].point.scan_count, 7);
  EXPECT_EQ(rows[0].point.yy_m2, 0.2F);
}

TEST(ExchangeTest, ErrorsNameTheRowTheFieldAndTheBound) {
  const EditableMap town = Town(true);
  const std::string json = *FormatLandmarkGeoJson(town);
  const auto geojson = [&](const std::string& from, const std::string& to) {
    return std::string(
        ParseLandmarkGeoJson(absl::StrReplaceAll(json, {{from, to}}), "t.geojson", *town.Anchor())
            .status()
            .message());
  };
  EXPECT_THAT(geojson("\"scan_count\":65530", "\"scan_count\":65536"),
              HasSubstr("t.geojson: feature 5: scan_count is 65536; it must be a whole number"));
  EXPECT_THAT(geojson("zz_m2", "zz"), HasSubstr("feature 0: has no property zz_m2"));
  EXPECT_THAT(geojson("\"keyframe\":0,", "\"keyframe\":\"a\","), HasSubstr("keyframe is \"a\""));
  EXPECT_THAT(geojson("FeatureCollection", "Feature"), HasSubstr("no FeatureCollection"));
  EXPECT_THAT(geojson("\"Point\"", "\"Polygon\""), HasSubstr("geometry is no Point"));
  EXPECT_THAT(geojson("\"features\":[", "\"features\":[1e9,"),
              HasSubstr("t.geojson: feature 0: is no object"));
  EXPECT_THAT(geojson("\"coordinates\":[", "\"coordinates\":[1e9,"),
              HasSubstr("t.geojson: feature 0: coordinates must be 2 or 3 numbers"));
  EXPECT_THAT(geojson("\"keyframe\":0,", "\"keyframe\":" + std::string(100'000, '[') +
                                             std::string(100'000, ']') + ","),
              HasSubstr("t.geojson: is nested 100004 deep; it must be at most 32"));

  const std::string pcd = FormatLandmarkPcd(town);
  const auto parse = [&](const std::string& bytes) {
    return std::string(ParseLandmarkPcd(bytes, "t.pcd", town.Origin_m()).status().message());
  };
  EXPECT_THAT(parse(absl::StrReplaceAll(pcd, {{"rcs_dbsm", "rcs"}})),
              HasSubstr("t.pcd: has no field rcs_dbsm"));
  EXPECT_THAT(parse(pcd.substr(0, pcd.size() - 1)), HasSubstr("POINTS is 108; the data hold 107"));
  EXPECT_THAT(parse(absl::StrReplaceAll(pcd, {{"DATA binary", "DATA binary_compressed"}})),
              HasSubstr("binary_compressed"));
  EXPECT_THAT(parse("no point cloud"), HasSubstr("is no PCD file"));

  Rows rows = RowsOf(town);
  rows[7].keyframe = 12;
  rows[7].name = "t.pcd: point 7";
  LandmarkEdits counts;
  EXPECT_THAT(ReplaceLandmarks(town, rows, counts).status().message(),
              HasSubstr("t.pcd: point 7: keyframe is 12; the base map has 12"));
  for (const double value : {1e300, -1.1e9, std::numeric_limits<double>::quiet_NaN()}) {
    rows[7] = rows[6];
    rows[7].name = "t.pcd: point 7";
    rows[7].p_map.x() = value;
    EXPECT_THAT(ReplaceLandmarks(town, rows, counts).status().message(),
                HasSubstr(absl::StrCat("t.pcd: point 7: x is ", value,
                                       " m in the map; it must lie in [-1.01e+09, 1.01e+09]")));
  }
  rows[7] = rows[6];
  rows[7].name = "t.pcd: point 7";
  rows[7].point.xx_m2 = -1.0F;
  EXPECT_THAT(ReplaceLandmarks(town, rows, counts).status().message(),
              HasSubstr("point 7: its covariance is not positive semidefinite"));
  EXPECT_FALSE(ReplaceLandmarks(town, {}, counts).ok());
  EXPECT_FALSE(FormatLandmarkGeoJson(Town(false)).ok());
}

}  // namespace
}  // namespace dcloc
