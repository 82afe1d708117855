#include "server/identity/role.h"

#include <algorithm>

namespace dcloc::server {
namespace {

/// Each row says from which role on a permission is held; vehicles stand apart.
struct Grant {
  Permission permission;
  absl::string_view name;
  bool vehicle;
  Role from;
  bool whole_server = false;
};

constexpr std::array kGrants = {
    Grant{Permission::kLocalize, "localize", true, Role::kOperator},
    Grant{Permission::kReadCoverage, "read_coverage", true, Role::kViewer},
    Grant{Permission::kReadMaps, "read_maps", false, Role::kViewer},
    Grant{Permission::kManageMaps, "manage_maps", false, Role::kOperator},
    Grant{Permission::kReadSessions, "read_sessions", false, Role::kViewer},
    Grant{Permission::kManageSessions, "manage_sessions", false, Role::kOperator},
    Grant{Permission::kReadServer, "read_server", false, Role::kViewer, true},
    Grant{Permission::kManageServer, "manage_server", false, Role::kAdmin, true},
};

const Grant& GrantOf(Permission permission) {
  return *std::ranges::find(kGrants, permission, &Grant::permission);
}

}  // namespace

absl::string_view NameOf(Permission permission) { return GrantOf(permission).name; }

absl::string_view NameOf(Role role) {
  switch (role) {
    case Role::kVehicle:
      return "vehicle";
    case Role::kViewer:
      return "viewer";
    case Role::kOperator:
      return "operator";
    case Role::kAdmin:
      break;
  }
  return "admin";
}

std::optional<Role> RoleFromName(absl::string_view name) {
  const auto* role = std::ranges::find_if(kRoles, [&](Role r) { return NameOf(r) == name; });
  return role == kRoles.end() ? std::nullopt : std::optional(*role);
}

bool Grants(Role role, absl::string_view tenant, Permission permission) {
  const Grant& grant = GrantOf(permission);
  if (grant.whole_server && !tenant.empty()) return false;
  return role == Role::kVehicle ? grant.vehicle : role >= grant.from;
}

}  // namespace dcloc::server
