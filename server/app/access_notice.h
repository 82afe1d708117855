#pragma once

#include "absl/status/status.h"
#include "server/config/config.h"
#include "server/identity/access_control.h"

namespace dcloc::server {

/// Logs that everyone who reaches the server is an admin, if that is so. Errors of the identities'.
absl::Status WarnOfOpenAccess(const AccessControl& access, const ServerConfig& config);

}  // namespace dcloc::server
