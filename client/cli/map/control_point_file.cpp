#include "client/cli/map/control_point_file.h"

#include <array>
#include <fstream>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"

namespace dcloc::cli {
namespace {

struct Column {
  const char* name;
  double min;
  double max;
};
constexpr std::array<Column, 5> kColumns = {{{"x_m", -1e8, 1e8},
                                             {"y_m", -1e8, 1e8},
                                             {"latitude_deg", -90.0, 90.0},
                                             {"longitude_deg", -180.0, 180.0},
                                             {"height_m", -1e5, 1e5}}};
constexpr std::size_t kNeeded = 4;  // of the columns

std::string HeaderOf(std::size_t column_count) {
  const auto name = [](std::string* text, const Column& column) { *text += column.name; };
  return absl::StrJoin(kColumns.begin(), kColumns.begin() + column_count, ",", name);
}

absl::StatusOr<ControlPoint> PointOf(const std::vector<std::string>& fields) {
  std::array<double, kColumns.size()> values{};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Column& column = kColumns[i];
    if (!absl::SimpleAtod(fields[i], &values[i]) || !(values[i] >= column.min) ||
        !(values[i] <= column.max)) {
      return absl::DataLossError(absl::StrFormat("%s is \"%s\"; it must be a number in [%g, %g]",
                                                 column.name, fields[i], column.min, column.max));
    }
  }
  return ControlPoint{
      .p_map_m = {values[0], values[1]},
      .position = {.latitude_deg = values[2], .longitude_deg = values[3], .height_m = values[4]}};
}

}  // namespace

absl::StatusOr<std::vector<ControlPoint>> ReadControlPoints(const std::string& file) {
  std::ifstream in(file);
  if (!in) return absl::NotFoundError(absl::StrCat(file, ": cannot be read"));
  std::vector<ControlPoint> points;
  std::size_t field_count = 0;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const std::vector<std::string> fields = absl::StrSplit(line, ',');
    if (number == 1) {
      field_count = fields.size();
      if (line == HeaderOf(kNeeded) || line == HeaderOf(kColumns.size())) continue;
      return absl::DataLossError(absl::StrFormat("%s, line 1: is \"%s\"; it must be %s[,height_m]",
                                                 file, line, HeaderOf(kNeeded)));
    }
    if (line.empty()) continue;
    if (fields.size() != field_count) {
      return absl::DataLossError(absl::StrFormat("%s, line %d: has %d fields; it must have %d",
                                                 file, number, fields.size(), field_count));
    }
    const absl::StatusOr<ControlPoint> point = PointOf(fields);
    if (!point.ok()) {
      return absl::DataLossError(
          absl::StrFormat("%s, line %d: %s", file, number, point.status().message()));
    }
    points.push_back(*point);
  }
  return points;
}

}  // namespace dcloc::cli
