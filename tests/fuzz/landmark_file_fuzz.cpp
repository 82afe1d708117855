#include "client/landmarks/landmark_geojson.h"
#include "client/landmarks/landmark_pcd.h"
#include "client/landmarks/pcd_table.h"
#include "client/landmarks/region_geojson.h"
#include "tests/core/map/synthetic_map.h"
#include "tests/fuzz/fuzz_target.h"

namespace dcloc {
namespace {

constexpr GeodeticAnchor kAnchor{.origin = {.latitude_deg = -33.0, .longitude_deg = 151.0},
                                 .x_axis_east_rad = 2.0};

EditableMap SmallTown() {
  SyntheticMap synthetic(2, 3);
  synthetic.info.local_origin_m = {1234.5, -3456.7, 8.9};  // not far from the anchor
  synthetic.info.flags = kHasAnchorFlag;
  synthetic.info.anchor_latitude_deg = -33.0;
  synthetic.info.anchor_longitude_deg = 151.0;
  synthetic.info.anchor_x_axis_east_rad = 2.0;
  return ToEditable(**RadarMap::FromBytes(synthetic.Bytes()));
}

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  const EditableMap town = SmallTown();
  const std::string pcd = FormatLandmarkPcd(town);
  const std::string geojson = *FormatLandmarkGeoJson(town);
  Require(ParseLandmarkPcd(pcd, "seed", town.Origin_m()).ok() &&
              ParseLandmarkGeoJson(geojson, "seed", kAnchor).ok(),
          "the seeds are valid");
  return {InputOf(pcd), InputOf(geojson),
          InputOf("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rcs\nSIZE 4 4 8 2\nTYPE F F F I\n"
                  "COUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n"
                  "DATA ascii\n1 2 3 4\n5 6 nan -8\n"),
          InputOf(R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},)"
                  R"("geometry":{"type":"Polygon","coordinates":[[[151,-33],[151.001,-33],)"
                  R"([151.001,-33.001],[151,-33]]]}}]})"),
          InputOf(R"({"type":"MultiPolygon","coordinates":[[[[151,-33],[151.001,-33],)"
                  R"([151,-33.001],[151,-33]]]]})")};
}

}  // namespace dcloc

// The same bytes as each of the files that other tools write.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (const auto table = dcloc::ParsePcd(bytes); table.ok()) {
    dcloc::Require(table->rows.size() <= size, "each row has bytes of the file");
    for (const auto& row : table->rows) {
      dcloc::Require(row.size() == table->fields.size(), "each row has all fields");
    }
  }
  static_cast<void>(dcloc::ParseLandmarkPcd(bytes, "input", {1.0, 2.0, 3.0}));
  static_cast<void>(dcloc::ParseLandmarkGeoJson(bytes, "input", dcloc::kAnchor));
  static_cast<void>(dcloc::ParseRegionGeoJson(bytes, "input", dcloc::kAnchor));
  return 0;
}
