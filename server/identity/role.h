#pragma once

#include <array>
#include <optional>

#include "absl/strings/string_view.h"

namespace dcloc::server {

/// Permissions. `MethodPermissions` says which one each RPC needs.
enum class Permission {
  kLocalize,        ///< open sessions; a vehicle only those of its own name
  kReadCoverage,    ///< ask which places are mapped
  kReadMaps,        ///< list and download the tenant's maps
  kManageMaps,      ///< upload, build, activate and delete them
  kReadSessions,    ///< list the tenant's sessions
  kManageSessions,  ///< record and end them
  kReadServer,      ///< the server as a whole; only in the default tenant
  kManageServer,    ///< drain it; only in the default tenant
};

enum class Role { kVehicle, kViewer, kOperator, kAdmin };

/// All roles, in the order of the enumeration.
inline constexpr std::array kRoles = {Role::kVehicle, Role::kViewer, Role::kOperator, Role::kAdmin};

/// "manage_maps".
absl::string_view NameOf(Permission permission);

/// "vehicle", "viewer", "operator", "admin".
absl::string_view NameOf(Role role);
std::optional<Role> RoleFromName(absl::string_view name);

/// Whether who has `role` in the tenant (empty: the default one) holds `permission`.
bool Grants(Role role, absl::string_view tenant, Permission permission);

}  // namespace dcloc::server
