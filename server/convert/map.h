#pragma once

#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/store/map_tile.h"

namespace dcloc::server::convert {

void ToProto(const MapRecord& record, v1::Map* message);
void ToProto(const MapVersionRecord& record, v1::MapVersion* message);
void ToProto(const CoverageRecord& record, v1::MapCoverage* message);

void ToProto(const KeyframeAccuracy& accuracy, v1::ExpectedAccuracy* message);

/// Everything but the version.
void ToProto(const MapTile& tile, v1::ReadMapTileResponse* message);

/// A place in a map's frame.
struct MapPlace {
  std::string map_name;
  Eigen::Vector2d p_map;
};

/// A place, and how far around it.
struct CoverageQuery {
  std::variant<GeodeticPosition, MapPlace> place;
  double radius_m = 0.0;
};

absl::StatusOr<CoverageQuery> FromProto(const v1::FindCoverageRequest& message);

/// The tile that a request asks for.
struct TileQuery {
  Rectangle bounds_m;
  std::size_t max_point_count = 0;
};

absl::StatusOr<TileQuery> FromProto(const v1::ReadMapTileRequest& message);

/// OK for 64 lower-case hexadecimal digits.
absl::Status CheckSha256(absl::string_view field, absl::string_view sha256);

/// OK for what `SetMapCanary` may ask for.
absl::Status Check(const v1::SetMapCanaryRequest& message);

}  // namespace dcloc::server::convert
