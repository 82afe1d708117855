#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "absl/status/status.h"

namespace dcloc::cli {

/// Writes `bytes` to `path` so that whoever opens it sees the old file or the whole new one: into a
/// temporary file beside it, to the disk, then renamed. Errors name the path and the reason.
absl::Status WriteFileAtomically(const std::filesystem::path& path,
                                 std::span<const std::byte> bytes);

}  // namespace dcloc::cli
