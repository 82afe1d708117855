#include "server/passes/pass_rows.h"

#include "absl/strings/str_format.h"

namespace dcloc::server {

absl::Status NoConsent() {
  return absl::PermissionDeniedError("the map or the identity does not consent to keeping passes");
}

absl::Status CheckQuota(std::int64_t size_bytes, std::int64_t tenant_bytes,
                        std::int64_t vehicle_bytes, const PassQuota& quota) {
  if (tenant_bytes + size_bytes > quota.max_tenant_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("the tenant's passes would have %d bytes; pass_storage_mib allows %d",
                        tenant_bytes + size_bytes, quota.max_tenant_bytes));
  }
  if (vehicle_bytes + size_bytes > quota.max_vehicle_bytes_per_day) {
    return absl::ResourceExhaustedError(absl::StrFormat(
        "the vehicle's passes of a day would have %d bytes; pass_vehicle_mib_per_day allows %d",
        vehicle_bytes + size_bytes, quota.max_vehicle_bytes_per_day));
  }
  return absl::OkStatus();
}

}  // namespace dcloc::server
