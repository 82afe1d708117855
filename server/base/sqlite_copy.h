#pragma once

#include <filesystem>

#include "absl/status/status.h"

namespace dcloc::server {

/// Copies an SQLite database into a file of its own, as it is at one moment, also while others
/// write to it, who are not held up. A file at `to` is replaced at once, when the copy is whole and
/// durable. NotFound: there is no database at `from`; DataLoss: it is damaged.
absl::Status CopyDatabase(const std::filesystem::path& from, const std::filesystem::path& to);

/// DataLoss names the first fault that SQLite finds in a database. Reads all of it, changes
/// nothing.
absl::Status CheckDatabase(const std::filesystem::path& path);

}  // namespace dcloc::server
