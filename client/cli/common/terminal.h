#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"

namespace dcloc::cli {

/// Prints an error on stderr and returns the exit code for it.
int Fail(const absl::Status& status);

/// Rows of cells in aligned columns: the first column to the left, the others to the right. The
/// first row is the header.
std::string FormatTable(const std::vector<std::vector<std::string>>& rows);

/// "512 B", "13.4 kB", "2.1 MB".
std::string FormatBytes(double bytes);

}  // namespace dcloc::cli
