#include "server/app/access_notice.h"

#include "absl/status/statusor.h"
#include "server/net/listen_address.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

absl::Status WarnOfOpenAccess(const AccessControl& access, const ServerConfig& config) {
  const absl::StatusOr<bool> open = access.IsOpen();
  if (!open.ok()) return open.status();
  if (!*open) return absl::OkStatus();
  const absl::StatusOr<ListenAddress> address = ParseListenAddress(config.listen);
  if (!address.ok()) return address.status();
  const auto level = address->IsLoopback() ? spdlog::level::info : spdlog::level::warn;
  spdlog::log(level,
              "no identities: whoever reaches {} is an admin; \"dcloc-server token create\" makes "
              "the first one",
              config.listen);
  return absl::OkStatus();
}

}  // namespace dcloc::server
