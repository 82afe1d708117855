#include "client/datasets/files/stamped_rows.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/datasets/files/file_error.h"
#include "client/trajectory/decimal_stamp.h"

namespace dcloc {
namespace {

std::optional<Stamp> StampOf(absl::string_view text, StampUnit unit) {
  if (unit == StampUnit::kSeconds) return StampOfSeconds(text);
  std::int64_t nanoseconds = 0;
  if (!absl::SimpleAtoi(text, &nanoseconds) || nanoseconds < 0) return std::nullopt;
  return Stamp(std::chrono::nanoseconds(nanoseconds));
}

absl::StatusOr<StampedRow> RowOf(absl::string_view line, StampUnit unit,
                                 std::span<const char* const> columns) {
  const std::vector<absl::string_view> cells =
      absl::StrSplit(line, absl::ByAnyChar(", \t\r"), absl::SkipEmpty());
  if (cells.size() < columns.size() + 1) {
    return absl::DataLossError(absl::StrCat("has ", cells.size(), " values; at least ",
                                            columns.size() + 1, " are needed"));
  }
  const std::optional<Stamp> stamp = StampOf(cells[0], unit);
  if (!stamp) return absl::DataLossError(absl::StrCat("the stamp is '", cells[0], "'"));
  StampedRow row{*stamp, std::vector<double>(columns.size())};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!absl::SimpleAtod(cells[i + 1], &row.values[i]) || !std::isfinite(row.values[i])) {
      return absl::DataLossError(
          absl::StrCat(columns[i], " is '", cells[i + 1], "'; it must be a number"));
    }
  }
  return row;
}

bool IsLeftOut(absl::string_view line, std::size_t number) {
  return line.empty() || line.front() == '#' ||
         (number == 1 && absl::ascii_isalpha(static_cast<unsigned char>(line.front())));
}

}  // namespace

absl::StatusOr<std::vector<StampedRow>> ReadStampedRows(const std::filesystem::path& path,
                                                        StampUnit unit,
                                                        std::span<const char* const> columns) {
  std::ifstream file(path);
  if (!file) return CannotOpen(path);
  std::vector<StampedRow> rows;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    const absl::string_view text = absl::StripAsciiWhitespace(line);
    if (IsLeftOut(text, number)) continue;
    absl::StatusOr<StampedRow> row = RowOf(text, unit, columns);
    if (row.ok() && !rows.empty() && row->stamp <= rows.back().stamp) {
      row = absl::DataLossError(absl::StrCat(
          "the stamp is ", row->stamp.time_since_epoch().count(), " ns; it must be after ",
          rows.back().stamp.time_since_epoch().count(), " ns, the one before"));
    }
    if (!row.ok()) {
      return FileError(path, absl::StrCat("line ", number, ": ", row.status().message()));
    }
    rows.push_back(*std::move(row));
  }
  return rows;
}

absl::StatusOr<std::vector<StampedPose>> ReadStampedPoses(const std::filesystem::path& path,
                                                          StampUnit unit) {
  constexpr std::array kColumns = {"x", "y", "z", "qx", "qy", "qz", "qw"};
  constexpr double kMaxNormError = 0.01;
  const auto rows = ReadStampedRows(path, unit, kColumns);
  if (!rows.ok()) return rows.status();
  std::vector<StampedPose> poses;
  for (const StampedRow& row : *rows) {
    const std::vector<double>& v = row.values;
    const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
    if (std::abs(rotation.norm() - 1.0) > kMaxNormError) {
      return FileError(
          path, absl::StrCat("at ", row.stamp.time_since_epoch().count(),
                             " ns: the quaternion's norm is ", rotation.norm(), "; it must be 1"));
    }
    poses.push_back({row.stamp, {{v[0], v[1], v[2]}, rotation.normalized()}});
  }
  return poses;
}

}  // namespace dcloc
