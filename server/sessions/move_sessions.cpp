#include "server/sessions/move_sessions.h"

#include <string>
#include <utility>

#include "server/base/status.h"
#include "server/sessions/session.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

void LogNotMoved(const SessionInfo& info, absl::string_view reason) {
  spdlog::warn("session not moved session={} reason={}", info.description.session_id,
               Quoted(reason));
}

}  // namespace

int MoveSessions(const SessionRegistry& registry, MapStore& store, absl::string_view tenant,
                 absl::string_view map_name, std::int64_t from_version) {
  const std::string scoped_name = ScopedMapName(tenant, map_name);
  int count = 0;
  for (const auto& session : registry.SessionsIn(tenant, map_name)) {
    const SessionInfo& info = *session->info();
    if (info.description.map_version_asked_for) continue;
    if (from_version != 0 && info.map_version != from_version) continue;
    absl::StatusOr<LoadedMap> map = store.AcquireFor(scoped_name, info.description.vehicle_id);
    if (!map.ok()) {
      LogNotMoved(info, map.status().message());
      continue;
    }
    if (map->record.version == info.map_version) continue;
    if (info.recorded) {
      LogNotMoved(info, "it is recorded, and a recording is of one version");
      continue;
    }
    ++count;
    session->strand().Post([session, loaded = *std::move(map)]() mutable {
      const absl::Status status = session->Move(std::move(loaded));
      if (!status.ok()) LogNotMoved(*session->info(), status.message());
    });
  }
  return count;
}

void EndSessions(SessionRegistry& registry, absl::string_view tenant, absl::string_view map_name,
                 std::int64_t version, EndOf which) {
  v1::SessionEnding ending;
  ending.set_reason(v1::SESSION_END_REASON_OPERATOR);
  ending.set_message("its map version is being deleted");
  for (const auto& session : registry.SessionsIn(tenant, map_name)) {
    const SessionInfo& info = *session->info();
    const bool stays = info.description.map_version_asked_for || info.recorded;
    if (version != 0 && info.map_version != version) continue;
    if (which == EndOf::kNotMoved && !stays) continue;
    // One that has just ended by itself is not found, which is as well.
    registry.End(info.description.session_id, tenant, ending).IgnoreError();
  }
}

}  // namespace dcloc::server
