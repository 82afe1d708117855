#include "client/cli/common/terminal.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "client/cli/common/exit_codes.h"

namespace dcloc::cli {

namespace {

/// The bytes of the first character if it is whole and well-formed UTF-8; else 0.
std::size_t CharacterSize(absl::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < size) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return 0;
  }
  return size;
}

/// Control characters of ASCII and of Latin-1, line separators, and those that turn the direction.
bool IsHarmless(absl::string_view character) {
  if (character.size() == 1) return !absl::ascii_iscntrl(static_cast<unsigned char>(character[0]));
  const auto second = static_cast<unsigned char>(character[1]);
  if (character[0] == '\xc2') return second >= 0xa0;
  if (!absl::StartsWith(character, "\xe2\x80") && !absl::StartsWith(character, "\xe2\x81")) {
    return true;
  }
  const auto third = static_cast<unsigned char>(character[2]);
  const bool turns = second == 0x80
                         ? (third >= 0x8e && third <= 0x8f) || (third >= 0xa8 && third <= 0xae)
                         : third >= 0xa6 && third <= 0xa9;
  return !turns;
}

}  // namespace

std::string Visible(absl::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t size = CharacterSize(text);
    const absl::string_view character = text.substr(0, std::max<std::size_t>(size, 1));
    const bool as_is = size > 0 && IsHarmless(character);
    absl::StrAppend(&shown, as_is ? std::string(character) : absl::CHexEscape(character));
    text.remove_prefix(character.size());
  }
  return shown;
}

int Fail(const absl::Status& status) {
  std::vector<std::string> lines;
  for (const absl::string_view line : absl::StrSplit(status.message(), '\n')) {
    lines.push_back(Visible(line));
  }
  absl::FPrintF(stderr, "dcloc: %s\n", absl::StrJoin(lines, "\n"));
  return kFailure;
}

std::string FormatTable(const std::vector<std::vector<std::string>>& cells) {
  std::vector<std::vector<std::string>> rows = cells;
  for (auto& row : rows) std::ranges::transform(row, row.begin(), Visible);
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
