#pragma once

#include <cstdint>

#include "absl/strings/string_view.h"
#include "server/maps/store/map_store.h"
#include "server/sessions/session_registry.h"

namespace dcloc::server {

/// Moves the tenant's sessions in a map to the version that each would get if it were opened now,
/// except those that asked for a version. Returns how many will be moved: each moves on its strand,
/// between two scans. One that cannot be moved keeps its version, and the log says why.
/// `from_version`: only sessions in that one; 0 for any.
int MoveSessions(const SessionRegistry& registry, MapStore& store, absl::string_view tenant,
                 absl::string_view map_name, std::int64_t from_version = 0);

/// Which sessions are ended.
enum class EndOf { kNotMoved, kAll };

/// Tells and ends the tenant's sessions in a version (0: in any) of a map: all, or those that
/// `MoveSessions` leaves there since they asked for it or are recorded.
void EndSessions(SessionRegistry& registry, absl::string_view tenant, absl::string_view map_name,
                 std::int64_t version, EndOf which);

}  // namespace dcloc::server
