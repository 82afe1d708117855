#include "server/convert/map.h"

#include <limits>

#include "absl/strings/str_cat.h"
#include "server/base/check.h"
#include "server/base/sha256.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
#include "server/convert/time.h"
#include "server/identity/principal.h"

namespace dcloc::server::convert {
namespace {

constexpr double kMaxCoverageRadius_m = 10'000.0;
constexpr double kMaxTileWidth_m = 5000.0;
constexpr int kMaxTilePoints = 50'000;
constexpr int kDefaultTilePoints = 20'000;

absl::Status CheckCoordinate(absl::string_view field, double value) {
  return CheckBetween(field, value, -kMaxWireCoordinate_m, kMaxWireCoordinate_m);
}

void SetInfo(const MapInfo& info, v1::MapInfo* message) {
  message->set_drive_name(info.name);
  message->set_description(info.description);
  message->set_keyframe_count(static_cast<std::int64_t>(info.keyframe_count));
  message->set_point_count(static_cast<std::int64_t>(info.point_count));
  message->set_length_m(info.length_m);
  ToProto(info.min_map_m, message->mutable_min_map_m());
  ToProto(info.max_map_m, message->mutable_max_map_m());
  message->set_has_elevation(info.has_elevation);
  if (info.anchor) ToProto(*info.anchor, message->mutable_anchor());
}

}  // namespace

void ToProto(const MapRecord& record, v1::Map* message) {
  message->set_name(std::string(UnscopedMapName(record.name)));
  message->set_active_version(record.active_version);
  message->set_version_count(record.version_count);
  message->set_previous_version(record.previous_version);
  message->set_canary_version(record.canary_version);
  message->set_canary_share(record.canary_share);
  *message->mutable_create_time() = ToProto(record.create_time);
}

void ToProto(const MapVersionRecord& record, v1::MapVersion* message) {
  message->set_map_name(std::string(UnscopedMapName(record.map_name)));
  message->set_version(record.version);
  message->set_active(record.active);
  message->set_size_bytes(static_cast<std::int64_t>(record.info.size_bytes));
  message->set_sha256(record.sha256);
  *message->mutable_create_time() = ToProto(record.create_time);
  SetInfo(record.info, message->mutable_info());
}

void ToProto(const CoverageRecord& record, v1::MapCoverage* message) {
  message->set_map_name(std::string(UnscopedMapName(record.map_name)));
  message->set_version(record.version);
  message->set_distance_m(record.distance_m);
}

void ToProto(const KeyframeAccuracy& accuracy, v1::ExpectedAccuracy* message) {
  if (accuracy.sigmas) {
    message->set_along_sigma_m(accuracy.sigmas->along_m);
    message->set_across_sigma_m(accuracy.sigmas->across_m);
    message->set_heading_sigma_rad(accuracy.sigmas->heading_rad);
  }
  message->set_is_tunnel(accuracy.is_tunnel);
  message->set_is_alias(accuracy.is_alias);
}

void ToProto(const MapTile& tile, v1::ReadMapTileResponse* message) {
  ToProto(tile.origin_map_m, message->mutable_origin_m());
  message->set_point_count(tile.point_count);
  for (const TilePoint& point : tile.points) {
    message->add_x_m(point.p_tile_m.x());
    message->add_y_m(point.p_tile_m.y());
    message->add_z_m(point.p_tile_m.z());
    message->add_rcs_dbsm(point.rcs_dbsm);
  }
  for (const TileKeyframe& keyframe : tile.keyframes) {
    message->add_keyframe_x_m(keyframe.p_tile_m.x());
    message->add_keyframe_y_m(keyframe.p_tile_m.y());
    if (keyframe.accuracy) ToProto(*keyframe.accuracy, message->add_keyframe_accuracies());
  }
  // A map has it of all or of none; parts of two kinds may have been merged.
  if (message->keyframe_accuracies_size() != message->keyframe_x_m_size()) {
    message->clear_keyframe_accuracies();
  }
}

absl::StatusOr<CoverageQuery> FromProto(const v1::FindCoverageRequest& message) {
  CoverageQuery query{.place = {}, .radius_m = message.radius_m()};
  absl::Status status = CheckBetween("radius_m", message.radius_m(), 0.0, kMaxCoverageRadius_m);
  if (message.has_position()) {
    const absl::StatusOr<GeodeticPosition> position = FromProto(message.position(), "position");
    status.Update(position.status());
    if (position.ok()) query.place = *position;
  } else if (message.has_map_place()) {
    const v1::MapPlace& place = message.map_place();
    status.Update(CheckMapName("map_place.map_name", place.map_name()));
    status.Update(CheckCoordinate("map_place.x_m", place.x_m()));
    status.Update(CheckCoordinate("map_place.y_m", place.y_m()));
    query.place = MapPlace{.map_name = place.map_name(), .p_map = {place.x_m(), place.y_m()}};
  } else {
    status.Update(Missing("place"));
  }
  if (!status.ok()) return status;
  return query;
}

absl::StatusOr<TileQuery> FromProto(const v1::ReadMapTileRequest& message) {
  absl::Status status = CheckCoordinate("min_x_m", message.min_x_m());
  status.Update(CheckCoordinate("min_y_m", message.min_y_m()));
  status.Update(CheckBetween("max_x_m", message.max_x_m(), message.min_x_m(),
                             message.min_x_m() + kMaxTileWidth_m));
  status.Update(CheckBetween("max_y_m", message.max_y_m(), message.min_y_m(),
                             message.min_y_m() + kMaxTileWidth_m));
  status.Update(
      CheckIntegerBetween("max_point_count", message.max_point_count(), 0, kMaxTilePoints));
  if (!status.ok()) return status;
  const int count = message.max_point_count() == 0 ? kDefaultTilePoints : message.max_point_count();
  return TileQuery{.bounds_m = {.min_x = message.min_x_m(),
                                .max_x = message.max_x_m(),
                                .min_y = message.min_y_m(),
                                .max_y = message.max_y_m()},
                   .max_point_count = static_cast<std::size_t>(count)};
}

absl::Status CheckSha256(absl::string_view field, absl::string_view sha256) {
  if (IsSha256(sha256)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", Quoted(sha256), "; it must be 64 lower-case hexadecimal digits"));
}

absl::Status Check(const v1::SetMapCanaryRequest& message) {
  absl::Status status = CheckMapName("map_name", message.map_name());
  status.Update(CheckIntegerBetween("version", message.version(), 0,
                                    std::numeric_limits<std::int64_t>::max()));
  // A share of none is no canary, and without a canary there is no share.
  const bool none = message.version() == 0;
  status.Update(CheckBetween("share", message.share(),
                             none ? 0.0 : std::numeric_limits<double>::min(), none ? 0.0 : 1.0));
  return status;
}

}  // namespace dcloc::server::convert
