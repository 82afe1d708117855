#pragma once

#include <string>

#include "absl/status/status.h"

namespace dcloc::server {

/// A status' message, as text that matchers take.
inline std::string MessageOf(const absl::Status& status) { return std::string(status.message()); }

}  // namespace dcloc::server
