#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// A new bearer token's text: "dcloc_" and 32 random bytes in web-safe base64.
absl::StatusOr<std::string> NewToken();

/// What a store keeps of a token: its SHA-256 in hex.
std::string HashOfToken(absl::string_view token);

}  // namespace dcloc::server
