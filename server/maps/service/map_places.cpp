#include "server/maps/service/map_places.h"

#include <limits>
#include <variant>
#include <vector>

#include "server/base/check.h"
#include "server/convert/map.h"
#include "server/identity/principal.h"
#include "server/maps/store/map_tile.h"

namespace dcloc::server {
namespace {

constexpr int kMaxCoverages = 100;
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

}  // namespace

absl::Status FindCoverage(Catalogue& catalogue, const std::string& tenant,
                          const v1::FindCoverageRequest& request,
                          v1::FindCoverageResponse* response) {
  const absl::StatusOr<convert::CoverageQuery> query = convert::FromProto(request);
  if (!query.ok()) return query.status();
  const absl::StatusOr<std::vector<CoverageRecord>> records = Find(catalogue, tenant, *query);
  if (!records.ok()) return records.status();
  for (const CoverageRecord& record : *records) {
    convert::ToProto(record, response->add_coverages());
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
