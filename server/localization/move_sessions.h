#pragma once

#include "absl/strings/string_view.h"
#include "server/localization/session_registry.h"
#include "server/maps/map_store.h"

namespace dcloc::server {

/// Moves the tenant's sessions in a map to the version that each would get if it were opened now,
/// but for those that asked for a version. Gives how many are moved: each is when its strand comes
/// to it, between two scans. One that cannot be moved keeps its version, and the log says why.
int MoveSessions(const SessionRegistry& registry, MapStore& store, absl::string_view tenant,
                 absl::string_view map_name);

}  // namespace dcloc::server
