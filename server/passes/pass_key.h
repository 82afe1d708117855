#pragma once

#include <filesystem>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::server {

/// The key of the pseudonyms: a file of 64 hexadecimal digits that nobody but its owner may use.
/// InvalidArgument names the file and what is wrong, but not the key.
absl::StatusOr<std::string> ReadPassKey(const std::filesystem::path& file);

/// The same; a file that is not there is made, with a key of its own.
absl::StatusOr<std::string> ReadOrMakePassKey(const std::filesystem::path& file);

}  // namespace dcloc::server
