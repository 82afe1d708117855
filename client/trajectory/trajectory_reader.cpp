#include "client/trajectory/trajectory_reader.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client/trajectory/decimal_stamp.h"

namespace dcloc {
namespace {

using Cells = std::vector<absl::string_view>;

/// x y z qx qy qz qw, by their place in a row.
constexpr std::array kPoseColumns = {"x", "y", "z", "qx", "qy", "qz", "qw"};

struct Columns {
  std::size_t stamp = 0;
  std::array<std::size_t, kPoseColumns.size()> pose = {1, 2, 3, 4, 5, 6, 7};
  std::optional<std::size_t> state;
};

absl::StatusOr<Columns> ColumnsOf(const Cells& header) {
  const auto find = [&](absl::string_view name) {
    return static_cast<std::size_t>(std::ranges::find(header, name) - header.begin());
  };
  Columns columns{.stamp = find("stamp_ns"), .pose = {}, .state = std::nullopt};
  if (columns.stamp == header.size()) return absl::DataLossError("has no column stamp_ns");
  for (std::size_t i = 0; i < kPoseColumns.size(); ++i) {
    columns.pose[i] = std::min(find(kPoseColumns[i]), find(absl::StrCat(kPoseColumns[i], "_m")));
    if (columns.pose[i] == header.size()) {
      return absl::DataLossError(absl::StrCat("has no column ", kPoseColumns[i]));
    }
  }
  if (const std::size_t state = find("state"); state < header.size()) columns.state = state;
  return columns;
}

std::optional<Stamp> StampOf(absl::string_view text, TrajectoryFormat format) {
  if (format == TrajectoryFormat::kTum) return StampOfSeconds(text);
  std::int64_t nanoseconds = 0;
  if (!absl::SimpleAtoi(text, &nanoseconds) || nanoseconds < 0) return std::nullopt;
  return Stamp(std::chrono::nanoseconds(nanoseconds));
}

absl::StatusOr<TrajectoryPose> RowOf(const Cells& cells, const Columns& columns,
                                     TrajectoryFormat format) {
  const std::size_t needed = std::max({columns.stamp, *std::ranges::max_element(columns.pose),
                                       columns.state.value_or(0)}) +
                             1;
  if (cells.size() < needed) {
    return absl::DataLossError(
        absl::StrCat("has ", cells.size(), " values; at least ", needed, " are needed"));
  }
  const std::optional<Stamp> stamp = StampOf(cells[columns.stamp], format);
  if (!stamp) {
    return absl::DataLossError(absl::StrCat("the stamp is '", cells[columns.stamp], "'"));
  }
  std::array<double, kPoseColumns.size()> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const absl::string_view cell = cells[columns.pose[i]];
    if (!absl::SimpleAtod(cell, &values[i]) || !std::isfinite(values[i])) {
      return absl::DataLossError(absl::StrCat(kPoseColumns[i], " is '", cell, "'"));
    }
  }
  const Eigen::Quaterniond rotation(values[6], values[3], values[4], values[5]);
  if (std::abs(rotation.norm() - 1.0) > 0.01) {
    return absl::DataLossError(
        absl::StrCat("the quaternion's norm is ", rotation.norm(), "; it must be 1"));
  }
  return TrajectoryPose{*stamp, {{values[0], values[1], values[2]}, rotation.normalized()}};
}

Cells CellsOf(absl::string_view line, TrajectoryFormat format) {
  if (format == TrajectoryFormat::kCsv) return absl::StrSplit(line, ',');
  return absl::StrSplit(line, absl::ByAnyChar(" \t"), absl::SkipEmpty());
}

}  // namespace

absl::StatusOr<Trajectory> ParseTrajectory(absl::string_view text, TrajectoryFormat format,
                                           absl::string_view name) {
  if (format != TrajectoryFormat::kTum && format != TrajectoryFormat::kCsv) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": only TUM and CSV have stamps and poses to be compared"));
  }
  Trajectory trajectory{.name = std::string(name), .anchor = std::nullopt, .poses = {}};
  std::optional<Columns> columns;
  if (format == TrajectoryFormat::kTum) columns = Columns();
  int line_number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++line_number;
    line = absl::StripSuffix(line, "\r");
    if (line.empty() || line[0] == '#') continue;
    const Cells cells = CellsOf(line, format);
    absl::Status status;
    if (!columns) {
      const absl::StatusOr<Columns> found = ColumnsOf(cells);
      if (found.ok()) columns = *found;
      status = found.status();
    } else if (const auto row = RowOf(cells, *columns, format); row.ok()) {
      const bool is_pose = !columns->state || cells[*columns->state] != "INITIALIZING";
      if (is_pose) trajectory.poses.push_back(*row);
    } else {
      status = row.status();
    }
    if (!status.ok()) {
      return absl::DataLossError(
          absl::StrCat(name, ": line ", line_number, ": ", status.message()));
    }
  }
  if (trajectory.poses.empty()) {
    return absl::DataLossError(absl::StrCat(name, ": has no pose"));
  }
  SortByStamp(trajectory.poses);
  return trajectory;
}

absl::StatusOr<Trajectory> ReadTrajectory(const std::filesystem::path& path,
                                          TrajectoryFormat format) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": is a folder"));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::ErrnoToStatus(errno, path.string());
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) return absl::DataLossError(absl::StrCat(path.string(), ": cannot be read"));
  return ParseTrajectory(text, format, path.string());
}

}  // namespace dcloc
