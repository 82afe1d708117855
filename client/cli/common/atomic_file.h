#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "absl/status/status.h"

namespace dcloc::cli {

/// Writes `bytes` to `path` so that a reader sees either the old file or the whole new one. Writes
/// a temporary file beside it, syncs it and renames it. Errors name the path and the reason.
absl::Status WriteFileAtomically(const std::filesystem::path& path,
                                 std::span<const std::byte> bytes);

}  // namespace dcloc::cli
