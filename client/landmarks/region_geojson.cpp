#include "client/landmarks/region_geojson.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"

namespace dcloc {
namespace {

using Json = nlohmann::json;

constexpr int kMaxDepth = 8;

class RegionReader {
 public:
  explicit RegionReader(const GeodeticAnchor& anchor) : anchor_(anchor) {}

  absl::Status Read(const Json& json, int depth = 0) {
    if (depth > kMaxDepth) {
      return absl::InvalidArgumentError(
          absl::StrCat("collections lie more than ", kMaxDepth, " deep in one another"));
    }
    const Json type = json.is_object() ? json.value("type", Json()) : Json();
    if (type == "FeatureCollection") return ReadAll(json.value("features", Json()), depth);
    if (type == "GeometryCollection") return ReadAll(json.value("geometries", Json()), depth);
    if (type == "Feature") return Read(json.value("geometry", Json()), depth + 1);
    const Json coordinates = json.is_object() ? json.value("coordinates", Json()) : Json();
    if (type == "Polygon") return ReadPolygon(coordinates);
    if (type != "MultiPolygon" || !coordinates.is_array()) {
      return absl::InvalidArgumentError(
          absl::StrCat("type is ", type.is_string() ? type.get<std::string>() : "missing",
                       "; it must be Polygon, MultiPolygon, or a feature or collection of them"));
    }
    for (const Json& polygon : coordinates) {
      if (absl::Status status = ReadPolygon(polygon); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  PlanarRegion Take() && { return std::move(region_); }

 private:
  absl::Status ReadAll(const Json& list, int depth) {
    if (!list.is_array()) return absl::InvalidArgumentError("a collection has no list");
    for (const Json& one : list) {
      if (absl::Status status = Read(one, depth + 1); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status ReadPolygon(const Json& rings) {
    if (!rings.is_array()) return absl::InvalidArgumentError("a polygon has no rings");
    PlanarPolygon polygon;
    for (const Json& positions : rings) {
      if (!positions.is_array()) return absl::InvalidArgumentError("a ring has no positions");
      auto& ring_m = polygon.rings_m.emplace_back();
      for (const Json& position : positions) {
        if (!position.is_array() || position.size() < 2 || !position[0].is_number() ||
            !position[1].is_number()) {
          return absl::InvalidArgumentError("a position must be longitude and latitude");
        }
        const GeodeticPosition p{.latitude_deg = position[1].get<double>(),
                                 .longitude_deg = position[0].get<double>(),
                                 .height_m = anchor_.origin.height_m};
        if (absl::Status status = Validate(p); !status.ok()) return status;
        ring_m.emplace_back(MapFromGeodetic(anchor_, p).head<2>());
      }
    }
    region_.polygons.push_back(std::move(polygon));
    return absl::OkStatus();
  }

  const GeodeticAnchor& anchor_;
  PlanarRegion region_;
};

}  // namespace

absl::StatusOr<PlanarRegion> ParseRegionGeoJson(absl::string_view text, absl::string_view name,
                                                const GeodeticAnchor& anchor) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) return absl::DataLossError(absl::StrCat(name, ": is no JSON"));
  RegionReader reader(anchor);
  absl::Status status = reader.Read(json);
  PlanarRegion region = std::move(reader).Take();
  if (status.ok()) status = Validate(region);
  if (!status.ok()) {
    return absl::Status(status.code(), absl::StrCat(name, ": ", status.message()));
  }
  return region;
}

}  // namespace dcloc
