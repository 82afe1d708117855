#include "client/datasets/fix_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "client/datasets/files/check_range.h"
#include "client/datasets/files/file_error.h"
#include "core/geometry/degrees.h"
#include "core/radar/stamp.h"
#include "core/relocalization/gnss_prior.h"

namespace dcloc {
namespace {

constexpr const char* kStampColumn = "stamp_ns";

struct FixColumn {
  const char* name;
  double min;
  double max;
  int decimals;
};

/// Both kinds have position, sigmas, and an angle with its sigma, in this order.
constexpr std::size_t kFixColumnCount = 7;
constexpr std::size_t kFixAngle = 5;
using FixColumns = std::array<FixColumn, kFixColumnCount>;
using FixValues = std::array<std::optional<double>, kFixColumnCount>;

constexpr FixColumns kGeodeticFixColumns = {{{"latitude_deg", -90.0, 90.0, 10},
                                             {"longitude_deg", -180.0, 180.0, 10},
                                             {"height_m", -1e5, 1e5, 4},
                                             {"horizontal_sigma_m", 1e-3, 1e4, 4},
                                             {"vertical_sigma_m", 1e-3, 1e4, 4},
                                             {"heading_deg", 0.0, 360.0, 6},
                                             {"heading_sigma_deg", 1e-3, 180.0, 6}}};
constexpr FixColumns kMapFixColumns = {{{"x_m", -1e8, 1e8, 4},
                                        {"y_m", -1e8, 1e8, 4},
                                        {"z_m", -1e8, 1e8, 4},
                                        {"horizontal_sigma_m", 1e-3, 1e4, 4},
                                        {"vertical_sigma_m", 1e-3, 1e4, 4},
                                        {"yaw_deg", -360.0, 360.0, 6},
                                        {"yaw_sigma_deg", 1e-3, 180.0, 6}}};

/// Where the columns of a file are in its lines.
struct FixLayout {
  bool is_geodetic = true;
  std::size_t field_count = 0;
  std::size_t stamp = 0;
  std::array<std::optional<std::size_t>, kFixColumnCount> columns;

  const FixColumns& names() const { return is_geodetic ? kGeodeticFixColumns : kMapFixColumns; }
};

absl::StatusOr<FixLayout> FixLayoutOf(absl::string_view header) {
  const std::vector<std::string> names = absl::StrSplit(header, ',');
  const auto place_of = [&](absl::string_view name) -> std::optional<std::size_t> {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) return std::nullopt;
    return static_cast<std::size_t>(found - names.begin());
  };
  FixLayout layout{.is_geodetic = !place_of(kMapFixColumns[0].name), .field_count = names.size()};
  const std::optional<std::size_t> stamp = place_of(kStampColumn);
  if (!stamp) return absl::DataLossError("the header has no column stamp_ns");
  layout.stamp = *stamp;
  std::size_t known = 1;
  for (std::size_t i = 0; i < kFixColumnCount; ++i) {
    layout.columns[i] = place_of(layout.names()[i].name);
    known += layout.columns[i] ? 1 : 0;
    if (!layout.columns[i] && i < kFixAngle) {
      return absl::DataLossError(absl::StrCat("the header has no column ", layout.names()[i].name));
    }
  }
  if (layout.columns[kFixAngle].has_value() != layout.columns[kFixAngle + 1].has_value()) {
    return absl::DataLossError(absl::StrCat("the header must have both or none of ",
                                            layout.names()[kFixAngle].name, " and ",
                                            layout.names()[kFixAngle + 1].name));
  }
  if (known != names.size()) {
    return absl::DataLossError(absl::StrCat("the header has ", names.size(), " columns, and ",
                                            known, " of them are known"));
  }
  return layout;
}

absl::StatusOr<double> FixNumberOf(const FixColumn& column, absl::string_view text) {
  double value = 0.0;
  if (!absl::SimpleAtod(text, &value)) {
    return absl::DataLossError(absl::StrFormat("%s is \"%s\"; it must be a number in [%g, %g]",
                                               column.name, text, column.min, column.max));
  }
  if (absl::Status status = CheckRange(column.name, value, column.min, column.max); !status.ok()) {
    return status;
  }
  return value;
}

absl::StatusOr<Stamp> FixStampOf(absl::string_view text) {
  std::int64_t stamp_ns = 0;
  constexpr std::int64_t kMaxStamp_ns = kMaxStamp.time_since_epoch().count();
  if (!absl::SimpleAtoi(text, &stamp_ns) || stamp_ns < 1 || stamp_ns > kMaxStamp_ns) {
    return absl::DataLossError(absl::StrFormat(
        "stamp_ns is \"%s\"; it must be an integer in [1, %d]", text, kMaxStamp_ns));
  }
  return Stamp(std::chrono::nanoseconds(stamp_ns));
}

StampedFix FixOf(const FixLayout& layout, Stamp stamp, const FixValues& values) {
  const auto value = [&](std::size_t i) { return values[i].value_or(0.0); };
  if (!layout.is_geodetic) {
    return {stamp, MapFix{.p_map = {value(0), value(1), value(2)},
                          .horizontal_sigma_m = value(3),
                          .vertical_sigma_m = value(4),
                          .yaw_deg = values[kFixAngle],
                          .yaw_sigma_deg = value(kFixAngle + 1)}};
  }
  return {stamp, GnssFix{.position = {.latitude_deg = value(0),
                                      .longitude_deg = value(1),
                                      .height_m = value(2)},
                         .horizontal_sigma_m = value(3),
                         .vertical_sigma_m = value(4),
                         .heading_deg = values[kFixAngle],
                         .heading_sigma_deg = value(kFixAngle + 1)}};
}

absl::StatusOr<StampedFix> ReadFixRow(const FixLayout& layout, absl::string_view line) {
  const std::vector<absl::string_view> fields = absl::StrSplit(line, ',');
  if (fields.size() != layout.field_count) {
    return absl::DataLossError(absl::StrCat("has ", fields.size(), " columns; it must have ",
                                            layout.field_count, " as the header"));
  }
  const absl::StatusOr<Stamp> stamp = FixStampOf(fields[layout.stamp]);
  if (!stamp.ok()) return stamp.status();
  FixValues values;
  const auto is_given = [&](std::size_t i) {
    return layout.columns[i] && (i < kFixAngle || !fields[*layout.columns[i]].empty());
  };
  for (std::size_t i = 0; i < kFixColumnCount; ++i) {
    // An angle and its sigma are given together, or not at all.
    if (!is_given(i) && !(i >= kFixAngle && (is_given(kFixAngle) || is_given(kFixAngle + 1))))
      continue;
    const absl::StatusOr<double> number =
        FixNumberOf(layout.names()[i], fields[*layout.columns[i]]);
    if (!number.ok()) return number.status();
    values[i] = *number;
  }
  return FixOf(layout, *stamp, values);
}

FixValues FixValuesOf(const StampedFix& fix) {
  if (const auto* gnss = std::get_if<GnssFix>(&fix.position)) {
    FixValues values = {gnss->position.latitude_deg, gnss->position.longitude_deg,
                        gnss->position.height_m, gnss->horizontal_sigma_m, gnss->vertical_sigma_m};
    if (gnss->heading_deg) values[kFixAngle] = gnss->heading_deg;
    if (gnss->heading_deg) values[kFixAngle + 1] = gnss->heading_sigma_deg;
    return values;
  }
  const MapFix& map = std::get<MapFix>(fix.position);
  FixValues values = {map.p_map.x(), map.p_map.y(), map.p_map.z(), map.horizontal_sigma_m,
                      map.vertical_sigma_m};
  if (map.yaw_deg) values[kFixAngle] = map.yaw_deg;
  if (map.yaw_deg) values[kFixAngle + 1] = map.yaw_sigma_deg;
  return values;
}

}  // namespace

InitialPose PoseOf(const MapFix& fix) {
  MapPosition position{.p_map = fix.p_map,
                       .horizontal_sigma_m = fix.horizontal_sigma_m,
                       .vertical_sigma_m = fix.vertical_sigma_m,
                       .yaw_rad = std::nullopt,
                       .yaw_sigma_rad = fix.yaw_sigma_deg * kRadPerDeg};
  if (fix.yaw_deg) position.yaw_rad = *fix.yaw_deg * kRadPerDeg;
  return PriorFromPosition(position);
}

absl::StatusOr<std::vector<StampedFix>> ReadFixes(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) return CannotOpen(path);
  std::optional<FixLayout> layout;
  std::vector<StampedFix> fixes;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const absl::string_view text = absl::StripAsciiWhitespace(line);
    if (text.empty()) continue;
    const auto error = [&](const absl::Status& status) {
      return FileError(path, absl::StrCat("line ", number, ": ", status.message()));
    };
    if (!layout) {
      const absl::StatusOr<FixLayout> found = FixLayoutOf(text);
      if (!found.ok()) return error(found.status());
      layout = *found;
      continue;
    }
    absl::StatusOr<StampedFix> fix = ReadFixRow(*layout, text);
    if (!fix.ok()) return error(fix.status());
    fixes.push_back(*std::move(fix));
  }
  if (!layout) return FileError(path, "is empty; its first line must be a header");
  std::ranges::stable_sort(fixes, {}, &StampedFix::stamp);
  return fixes;
}

absl::Status WriteFixes(const std::filesystem::path& path, const std::vector<StampedFix>& fixes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  const bool is_geodetic = fixes.empty() || std::holds_alternative<GnssFix>(fixes.front().position);
  const FixColumns& columns = is_geodetic ? kGeodeticFixColumns : kMapFixColumns;
  file << kStampColumn;
  for (const FixColumn& column : columns) file << "," << column.name;
  file << "\n";
  for (const StampedFix& fix : fixes) {
    file << fix.stamp.time_since_epoch().count();
    const FixValues values = FixValuesOf(fix);
    for (std::size_t i = 0; i < kFixColumnCount; ++i) {
      file << (values[i] ? absl::StrFormat(",%.*f", columns[i].decimals, *values[i]) : ",");
    }
    file << "\n";
  }
  file.close();
  return file ? absl::OkStatus()
              : absl::UnavailableError(absl::StrCat(path.string(), ": cannot write"));
}

}  // namespace dcloc
