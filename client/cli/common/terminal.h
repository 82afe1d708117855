#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc::cli {

/// Text that somebody else has chosen (a drive's name, a vehicle's id, a server's message), as a
/// person's terminal may show it: control characters, which could move the cursor or change what
/// stands there, are written as \n, \x1b, and so are those that turn the direction of writing, and
/// bytes that are no UTF-8. All else is as it was.
std::string Visible(absl::string_view text);

/// Prints an error on stderr, line by line visible, and returns the exit code for it.
int Fail(const absl::Status& status);

/// Rows of cells in aligned columns: the first column to the left, the others to the right. The
/// first row is the header. Cells are made `Visible`.
std::string FormatTable(const std::vector<std::vector<std::string>>& cells);

/// "512 B", "13.4 kB", "2.1 MB".
std::string FormatBytes(double bytes);

}  // namespace dcloc::cli
