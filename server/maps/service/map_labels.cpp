#include "server/maps/service/map_labels.h"

#include <limits>

#include "server/base/check.h"
#include "server/convert/map.h"
#include "server/identity/principal.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// Logs and answers a change that was made.
absl::Status Answer(const char* change, const std::string& tenant,
                    const absl::StatusOr<MapRecord>& record, v1::Map* map) {
  if (!record.ok()) return record.status();
  convert::ToProto(*record, map);
  spdlog::info("map {} tenant={} map={} active={} previous={} canary={} share={}", change, tenant,
               map->name(), map->active_version(), map->previous_version(), map->canary_version(),
               map->canary_share());
  return absl::OkStatus();
}

}  // namespace

absl::Status Activate(MapStore& store, const SessionMover& move, const std::string& tenant,
                      const v1::ActivateMapVersionRequest& request,
                      v1::ActivateMapVersionResponse* response) {
  absl::Status status = CheckMapName("map_name", request.map_name());
  status.Update(CheckIntegerBetween("version", request.version(), 1,
                                    std::numeric_limits<std::int64_t>::max()));
  if (!status.ok()) return status;
  status = Answer("activated", tenant,
                  store.Activate(ScopedMapName(tenant, request.map_name()), request.version()),
                  response->mutable_map());
  if (!status.ok() || !request.move_sessions()) return status;
  response->set_moved_session_count(move(tenant, request.map_name()));
  return absl::OkStatus();
}

absl::Status RollBack(MapStore& store, const SessionMover& move, const std::string& tenant,
                      const v1::RollBackMapRequest& request, v1::RollBackMapResponse* response) {
  absl::Status status = CheckMapName("map_name", request.map_name());
  if (!status.ok()) return status;
  status = Answer("rolled back", tenant, store.RollBack(ScopedMapName(tenant, request.map_name())),
                  response->mutable_map());
  if (!status.ok() || !request.move_sessions()) return status;
  response->set_moved_session_count(move(tenant, request.map_name()));
  return absl::OkStatus();
}

absl::Status SetCanary(MapStore& store, const std::string& tenant,
                       const v1::SetMapCanaryRequest& request, v1::Map* map) {
  if (absl::Status status = convert::Check(request); !status.ok()) return status;
  return Answer("canary set", tenant,
                store.SetCanary(ScopedMapName(tenant, request.map_name()), request.version(),
                                request.share()),
                map);
}

}  // namespace dcloc::server
