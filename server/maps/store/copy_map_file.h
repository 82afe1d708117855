#pragma once

#include <filesystem>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// Copies a map file, a piece at a time, and compares its hash on the way. A file at `to` is
/// replaced at once, when the copy is whole and durable; otherwise nothing is left. NotFound;
/// DataLoss: the bytes have another hash. `pace` is called with the size of each piece; when it
/// returns false, Cancelled.
absl::Status CopyMapFile(const std::filesystem::path& from, const std::filesystem::path& to,
                         absl::string_view sha256, absl::FunctionRef<bool(std::size_t)> pace);

}  // namespace dcloc::server
