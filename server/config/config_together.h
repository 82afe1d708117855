#pragma once

#include "absl/status/status.h"
#include "server/config/config.h"

namespace dcloc::server {

/// OK where the settings fit each other, or InvalidArgument naming those that do not.
absl::Status ValidateTogether(const ServerConfig& config);

}  // namespace dcloc::server
