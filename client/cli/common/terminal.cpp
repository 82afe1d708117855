#include "client/cli/common/terminal.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/exit_codes.h"

namespace dcloc::cli {

int Fail(const absl::Status& status) {
  absl::FPrintF(stderr, "dcloc: %s\n", status.message());
  return kFailure;
}

std::string FormatTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string table;
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - row[i].size(), ' ');
      const bool is_last = i + 1 == row.size();
      absl::StrAppend(&table, i == 0 ? row[i] : "  ", i == 0 ? (is_last ? "" : padding) : padding,
                      i == 0 ? "" : row[i]);
    }
    table += '\n';
  }
  return table;
}

std::string FormatBytes(double bytes) {
  constexpr std::array kUnits = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  while (bytes >= 999.95 && unit + 1 < kUnits.size()) {
    bytes /= 1000.0;
    ++unit;
  }
  return absl::StrFormat("%.*f %s", unit == 0 ? 0 : 1, bytes, kUnits[unit]);
}

}  // namespace dcloc::cli
