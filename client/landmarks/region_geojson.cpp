#include "client/landmarks/region_geojson.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/landmarks/geojson_text.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

using Json = nlohmann::json;

constexpr int kMaxDepth = 8;
constexpr double kMaxEdge_m = 500.0;  // the arc's height over its chord is some millimetres
constexpr double kMaxFromAnchor_m = 500'000.0;
constexpr std::size_t kMaxVertexCount = 5'000'000;

// How many straight pieces an edge is cut into. Never too few: no radius of curvature is larger.
int PiecesOf(const GeodeticPosition& a, const GeodeticPosition& b) {
  constexpr double kRadius_m = 6.4e6;
  const bool crosses_equator = a.latitude_deg * b.latitude_deg < 0.0;
  const double nearest_deg =
      crosses_equator ? 0.0 : std::min(std::abs(a.latitude_deg), std::abs(b.latitude_deg));
  const double north_rad = (b.latitude_deg - a.latitude_deg) * kRadPerDeg;
  const double east_rad = std::remainder(b.longitude_deg - a.longitude_deg, 360.0) * kRadPerDeg *
                          std::cos(nearest_deg * kRadPerDeg);
  const double length_m = kRadius_m * std::hypot(north_rad, east_rad);
  return std::max(1, static_cast<int>(std::ceil(length_m / kMaxEdge_m)));
}

// The point `piece` / `count` along an edge that is straight in longitude and latitude. From the
// same end whichever way the edge goes, so that polygons that share it share the point.
GeodeticPosition PointOnEdge(GeodeticPosition a, GeodeticPosition b, int piece, int count) {
  if (std::pair(b.longitude_deg, b.latitude_deg) < std::pair(a.longitude_deg, a.latitude_deg)) {
    std::swap(a, b);
    piece = count - piece;
  }
  const double share = static_cast<double>(piece) / count;
  a.latitude_deg += share * (b.latitude_deg - a.latitude_deg);
  a.longitude_deg += share * std::remainder(b.longitude_deg - a.longitude_deg, 360.0);
  return a;
}

class RegionReader {
 public:
  explicit RegionReader(const GeodeticAnchor& anchor) : anchor_(anchor) {}

  absl::Status Read(const Json& json, int depth = 0) {
    if (depth > kMaxDepth) {
      return absl::InvalidArgumentError(
          absl::StrCat("collections lie more than ", kMaxDepth, " deep in one another"));
    }
    const Json& type = MemberOf(json, "type");
    if (type == "FeatureCollection") return ReadAll(MemberOf(json, "features"), depth);
    if (type == "GeometryCollection") return ReadAll(MemberOf(json, "geometries"), depth);
    if (type == "Feature") return Read(MemberOf(json, "geometry"), depth + 1);
    const Json& coordinates = MemberOf(json, "coordinates");
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
      std::vector<GeodeticPosition> vertices;
      for (const Json& position : positions) {
        if (!position.is_array() || position.size() < 2 || !position[0].is_number() ||
            !position[1].is_number()) {
          return absl::InvalidArgumentError("a position must be longitude and latitude");
        }
        const GeodeticPosition p{.latitude_deg = position[1].get<double>(),
                                 .longitude_deg = position[0].get<double>(),
                                 .height_m = anchor_.origin.height_m};
        if (absl::Status status = CheckVertex(p); !status.ok()) return status;
        vertices.push_back(p);
      }
      if (absl::Status status = Cut(vertices, polygon.rings_m.emplace_back()); !status.ok()) {
        return status;
      }
    }
    region_.polygons.push_back(std::move(polygon));
    return absl::OkStatus();
  }

  absl::Status CheckVertex(const GeodeticPosition& p) const {
    if (absl::Status status = Validate(p); !status.ok()) return status;
    const double distance_m = MapFromGeodetic(anchor_, p).norm();
    if (distance_m <= kMaxFromAnchor_m) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrFormat(
        "the position [%.9g, %.9g] lies %.1f km from the map's anchor; it must be at most %g km",
        p.longitude_deg, p.latitude_deg, distance_m / 1000.0, kMaxFromAnchor_m / 1000.0));
  }

  // The ring in the map, with its edges in pieces.
  absl::Status Cut(const std::vector<GeodeticPosition>& vertices,
                   std::vector<Eigen::Vector2d>& ring_m) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const GeodeticPosition& begin = vertices[i];
      const GeodeticPosition& end = vertices[(i + 1) % vertices.size()];
      // What is no ring is not made one.
      const int count = vertices.size() < 3 ? 1 : PiecesOf(begin, end);
      vertex_count_ += static_cast<std::size_t>(count);
      if (vertex_count_ > kMaxVertexCount) {
        return absl::InvalidArgumentError(absl::StrFormat(
            "has %d vertices or more, with edges cut to %g m; they must be at most %d",
            vertex_count_, kMaxEdge_m, kMaxVertexCount));
      }
      ring_m.emplace_back(MapFromGeodetic(anchor_, begin).head<2>());
      for (int piece = 1; piece < count; ++piece) {
        ring_m.emplace_back(
            MapFromGeodetic(anchor_, PointOnEdge(begin, end, piece, count)).head<2>());
      }
    }
    return absl::OkStatus();
  }

  const GeodeticAnchor& anchor_;
  PlanarRegion region_;
  std::size_t vertex_count_ = 0;
};

}  // namespace

absl::StatusOr<PlanarRegion> ParseRegionGeoJson(absl::string_view text, absl::string_view name,
                                                const GeodeticAnchor& anchor) {
  const absl::StatusOr<Json> json = ParseGeoJson(text, name);
  if (!json.ok()) return json.status();
  RegionReader reader(anchor);
  absl::Status status = reader.Read(*json);
  PlanarRegion region = std::move(reader).Take();
  if (status.ok()) status = Validate(region);
  if (!status.ok()) {
    return absl::Status(status.code(), absl::StrCat(name, ": ", status.message()));
  }
  return region;
}

}  // namespace dcloc
