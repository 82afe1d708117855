#pragma once

#include <filesystem>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::client {

/// The file's SHA-256 as 64 lower-case hexadecimal digits. Errors name the file and the reason.
absl::StatusOr<std::string> Sha256OfFile(const std::filesystem::path& path);

}  // namespace dcloc::client
