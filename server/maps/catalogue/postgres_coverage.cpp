#include "server/maps/catalogue/postgres_coverage.h"

#include <array>
#include <optional>
#include <string>
#include <utility>

#include "server/maps/catalogue/coverage_search.h"
#include "server/maps/catalogue/record_columns.h"

namespace dcloc::server {
namespace {

using Column = std::vector<std::optional<double>>;

/// In the order of the table.
std::array<Column, 8> ColumnsOf(const std::vector<CoverageBox>& boxes) {
  std::array<Column, 8> columns;
  for (const CoverageBox& box : boxes) {
    columns[0].emplace_back(box.map_m.min_x);
    columns[1].emplace_back(box.map_m.max_x);
    columns[2].emplace_back(box.map_m.min_y);
    columns[3].emplace_back(box.map_m.max_y);
    const auto degrees = [&](double Rectangle::*side) {
      return box.degrees ? std::optional((*box.degrees).*side) : std::nullopt;
    };
    columns[4].push_back(degrees(&Rectangle::min_x));
    columns[5].push_back(degrees(&Rectangle::max_x));
    columns[6].push_back(degrees(&Rectangle::min_y));
    columns[7].push_back(degrees(&Rectangle::max_y));
  }
  return columns;
}

void BindRectangle(const Rectangle& rectangle, PostgresValues* values) {
  values->Bind(rectangle.min_x).Bind(rectangle.min_y).Bind(rectangle.max_x).Bind(rectangle.max_y);
}

}  // namespace

absl::Status InsertCoverage(PostgresConnection& connection, absl::string_view map_name,
                            std::int64_t version, const std::vector<CoverageBox>& boxes) {
  PostgresValues values;
  values.Bind(map_name).Bind(version);
  for (const Column& column : ColumnsOf(boxes)) values.BindArray(column);
  return connection
      .Query(
          "INSERT INTO coverage_box SELECT $1::text, $2::bigint, box.* FROM unnest($3::float8[], "
          "$4::float8[],"
          " $5::float8[], $6::float8[], $7::float8[], $8::float8[], $9::float8[],"
          " $10::float8[]) AS box",
          values)
      .status();
}

absl::StatusOr<std::vector<CoverageRecord>> FindMapCoverage(PostgresConnection& connection,
                                                            absl::string_view map_name,
                                                            const Eigen::Vector2d& p_map,
                                                            double radius_m) {
  PostgresValues values;
  values.Bind(map_name);
  BindRectangle(Around(p_map.x(), p_map.y(), radius_m, radius_m), &values);
  // The boxes of one version are few: those are found by its key, and looked at one by one.
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "SELECT map_name, version, min_x_m, max_x_m, min_y_m, max_y_m FROM coverage_box"
      " JOIN map ON name = map_name AND active_version = version"
      " WHERE map_name = $1 AND on_map && ST_MakeEnvelope($2, $3, $4, $5)",
      values);
  if (!rows.ok()) return rows.status();
  NearestVersions nearest(radius_m);
  while (rows->Next()) {
    std::string name = rows->NextText();
    const std::int64_t version = rows->NextInteger();
    nearest.Add(std::move(name), version, DistanceTo(NextRectangle(*rows), p_map.x(), p_map.y()));
  }
  return nearest.Records();
}

absl::StatusOr<std::vector<CoverageRecord>> FindEarthCoverage(PostgresConnection& connection,
                                                              absl::string_view prefix,
                                                              const GeodeticPosition& position,
                                                              double radius_m) {
  const auto windows = EarthWindows(position, radius_m);
  PostgresValues values;
  values.Bind(prefix);
  for (const EarthWindow& window : windows) BindRectangle(window.reach, &values);
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "SELECT map_name, version, min_longitude_deg, max_longitude_deg, min_latitude_deg,"
      " max_latitude_deg FROM coverage_box"
      " JOIN map ON name = map_name AND active_version = version"
      " WHERE tenant = $1 AND (on_earth && ST_MakeEnvelope($2, $3, $4, $5)"
      " OR on_earth && ST_MakeEnvelope($6, $7, $8, $9)"
      " OR on_earth && ST_MakeEnvelope($10, $11, $12, $13))",
      values);
  if (!rows.ok()) return rows.status();
  NearestVersions nearest(radius_m);
  while (rows->Next()) {
    const std::string name = rows->NextText();
    const std::int64_t version = rows->NextInteger();
    const Rectangle degrees = NextRectangle(*rows);
    for (const EarthWindow& window : windows) {
      nearest.Add(name, version, window.DistanceTo_m(degrees));
    }
  }
  return nearest.Records();
}

}  // namespace dcloc::server
