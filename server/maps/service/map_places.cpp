#include "server/maps/service/map_places.h"

#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "server/base/check.h"
#include "server/convert/map.h"
#include "server/identity/principal.h"
#include "server/maps/store/map_tile.h"

namespace dcloc::server {
namespace {

constexpr int kMaxCoverages = 100;
constexpr int kMaxAccuracies = 10;
constexpr double kMaxRectangle_m = 75.0;
constexpr std::size_t kMaxTileKeyframes = 10'000;

absl::StatusOr<std::vector<CoverageRecord>> Find(Catalogue& catalogue, const std::string& tenant,
                                                 const convert::CoverageQuery& query) {
  if (const auto* position = std::get_if<GeodeticPosition>(&query.place)) {
    return catalogue.FindCoverage(ScopedMapName(tenant, ""), *position, query.radius_m,
                                  kMaxCoverages);
  }
  const auto& place = std::get<convert::MapPlace>(query.place);
  return catalogue.FindCoverage(ScopedMapName(tenant, place.map_name), place.p_map, query.radius_m);
}

/// At the keyframe nearest to the place. A map that has gone meanwhile has none.
absl::StatusOr<std::optional<KeyframeAccuracy>> AccuracyAt(MapStore& store,
                                                           const CoverageRecord& record,
                                                           const convert::CoverageQuery& query) {
  const absl::StatusOr<LoadedMap> loaded = store.Acquire(record.map_name, record.version);
  if (absl::IsNotFound(loaded.status())) return std::nullopt;
  if (!loaded.ok()) return loaded.status();
  const RadarMap& map = *loaded->map;
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();
  if (const auto* position = std::get_if<GeodeticPosition>(&query.place)) {
    p_map = MapFromGeodetic(*map.info().anchor, *position);
  } else {
    p_map.head<2>() = std::get<convert::MapPlace>(query.place).p_map;
  }
  // Rectangles around the street are at most that wide.
  const auto keyframe = map.NearestKeyframe(p_map, query.radius_m + kMaxRectangle_m);
  return keyframe ? map.accuracy(*keyframe) : std::nullopt;
}

}  // namespace

absl::Status FindCoverage(MapStore& store, const std::string& tenant,
                          const v1::FindCoverageRequest& request,
                          v1::FindCoverageResponse* response) {
  const absl::StatusOr<convert::CoverageQuery> query = convert::FromProto(request);
  if (!query.ok()) return query.status();
  const absl::StatusOr<std::vector<CoverageRecord>> records =
      Find(store.catalogue(), tenant, *query);
  if (!records.ok()) return records.status();
  for (const CoverageRecord& record : *records) {
    v1::MapCoverage* const coverage = response->add_coverages();
    convert::ToProto(record, coverage);
    if (!request.with_accuracy() || response->coverages_size() > kMaxAccuracies) continue;
    const absl::StatusOr<std::optional<KeyframeAccuracy>> accuracy =
        AccuracyAt(store, record, *query);
    if (!accuracy.ok()) return accuracy.status();
    if (*accuracy) convert::ToProto(**accuracy, coverage->mutable_accuracy());
  }
  return absl::OkStatus();
}

absl::Status ReadMapTile(MapStore& store, const std::string& tenant,
                         const v1::ReadMapTileRequest& request, v1::ReadMapTileResponse* response) {
  absl::Status status = CheckMapName("map_name", request.map_name());
  status.Update(CheckIntegerBetween("version", request.version(), 0,
                                    std::numeric_limits<std::int64_t>::max()));
  const absl::StatusOr<convert::TileQuery> query = convert::FromProto(request);
  status.Update(query.status());
  if (!status.ok()) return status;
  const absl::StatusOr<LoadedMap> map =
      store.Acquire(ScopedMapName(tenant, request.map_name()), request.version());
  if (!map.ok()) return map.status();
  response->set_version(map->record.version);
  convert::ToProto(ReadTile(*map->map, query->bounds_m, query->max_point_count, kMaxTileKeyframes),
                   response);
  return absl::OkStatus();
}

}  // namespace dcloc::server
