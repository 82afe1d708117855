#include "server/identity/principal.h"

#include "absl/strings/str_cat.h"
#include "server/base/status.h"

namespace dcloc::server {

std::string ScopedMapName(absl::string_view tenant, absl::string_view map_name) {
  return tenant.empty() ? std::string(map_name) : absl::StrCat(tenant, "/", map_name);
}

absl::string_view UnscopedMapName(absl::string_view scoped_name) {
  const std::size_t slash = scoped_name.find('/');
  return slash == absl::string_view::npos ? scoped_name : scoped_name.substr(slash + 1);
}

absl::Status CheckVehicle(const Principal& principal, absl::string_view vehicle_id) {
  if (principal.role != Role::kVehicle || principal.name == vehicle_id) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat("open.vehicle_id is ", Quoted(vehicle_id), "; a vehicle may only open sessions",
                   " of its own name, which is ", Quoted(principal.name)));
}

}  // namespace dcloc::server
