#pragma once

#include <filesystem>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::cli {

/// All bytes of a file. Errors name the path: NotFound and what else the system says,
/// InvalidArgument for a folder.
absl::StatusOr<std::string> ReadInputFile(const std::filesystem::path& path);

}  // namespace dcloc::cli
