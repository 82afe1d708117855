#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/identity/role.h"

namespace dcloc::server {

/// Who calls.
struct Principal {
  std::string name;    ///< a vehicle's is its vehicle_id
  std::string tenant;  ///< whose maps and sessions it sees; empty: the default tenant
  Role role = Role::kAdmin;

  friend bool operator==(const Principal&, const Principal&) = default;
};

/// A tenant's map in the catalogue: "acme/town", or "town" in the default tenant. Names of maps and
/// tenants contain no slash, so no tenant can name another tenant's map.
std::string ScopedMapName(absl::string_view tenant, absl::string_view map_name);

/// The name without its tenant.
absl::string_view UnscopedMapName(absl::string_view scoped_name);

/// PermissionDenied when a vehicle opens a session under another name than its own.
absl::Status CheckVehicle(const Principal& principal, absl::string_view vehicle_id);

}  // namespace dcloc::server
