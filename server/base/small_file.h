#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::server {

/// All of a file of settings or certificates. NotFound if it cannot be opened, InvalidArgument if
/// it is no regular file, cannot be read or is larger than `max_bytes`; both name it. Never waits
/// for a writer.
absl::StatusOr<std::string> ReadSmallFile(const std::filesystem::path& path,
                                          std::size_t max_bytes = std::size_t{1} << 20);

}  // namespace dcloc::server
