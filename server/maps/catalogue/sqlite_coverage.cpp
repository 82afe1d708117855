#include "server/maps/catalogue/sqlite_coverage.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/geometry/degrees.h"

namespace dcloc::server {
namespace {

/// Of a degree of latitude; its spread over the ellipsoid is 1 %, by which the search is widened.
constexpr double kDegree_m = 111'320.0;
constexpr double kWiden = 1.01;
/// Near the poles a degree of longitude is next to nothing.
constexpr double kMinCosine = 1e-6;

void BindRectangle(const Rectangle& rectangle, SqliteStatement* statement) {
  statement->Bind(rectangle.min_x)
      .Bind(rectangle.max_x)
      .Bind(rectangle.min_y)
      .Bind(rectangle.max_y);
}

Rectangle NextRectangle(SqliteStatement& row) {
  Rectangle rectangle;
  rectangle.min_x = row.NextReal();
  rectangle.max_x = row.NextReal();
  rectangle.min_y = row.NextReal();
  rectangle.max_y = row.NextReal();
  return rectangle;
}

/// What lies within half of `width` and half of `height` around a place.
Rectangle Around(double x, double y, double reach_x, double reach_y) {
  return {.min_x = x - reach_x, .max_x = x + reach_x, .min_y = y - reach_y, .max_y = y + reach_y};
}

using Nearest = std::map<std::pair<std::string, std::int64_t>, double>;

/// Goes through boxes and keeps each version's least distance within the radius.
template <typename Distance>
absl::Status Collect(SqliteStatement& query, double radius_m, const Distance& distance,
                     Nearest* nearest) {
  while (true) {
    const absl::StatusOr<bool> row = query.Step();
    if (!row.ok()) return row.status();
    if (!*row) return absl::OkStatus();
    std::string map_name = query.NextText();
    const std::int64_t version = query.NextInteger();
    const double distance_m = distance(NextRectangle(query));
    if (distance_m > radius_m) continue;
    const auto [entry, is_new] = nearest->try_emplace({std::move(map_name), version}, distance_m);
    entry->second = std::min(entry->second, distance_m);
  }
}

std::vector<CoverageRecord> Records(const Nearest& nearest) {
  std::vector<CoverageRecord> records;
  for (const auto& [key, distance_m] : nearest) {
    records.push_back({.map_name = key.first, .version = key.second, .distance_m = distance_m});
  }
  return records;
}

}  // namespace

const char* const kCreateCoverage = R"(
CREATE TABLE coverage_box (
  id INTEGER PRIMARY KEY,
  map_name TEXT NOT NULL,
  version INTEGER NOT NULL,
  min_x_m REAL NOT NULL, max_x_m REAL NOT NULL, min_y_m REAL NOT NULL, max_y_m REAL NOT NULL,
  min_longitude_deg REAL, max_longitude_deg REAL, min_latitude_deg REAL, max_latitude_deg REAL,
  FOREIGN KEY (map_name, version) REFERENCES map_version(map_name, version) ON DELETE CASCADE
) STRICT;

CREATE INDEX coverage_box_version ON coverage_box(map_name, version);

CREATE VIRTUAL TABLE coverage_map USING rtree(id, min_x, max_x, min_y, max_y);
CREATE VIRTUAL TABLE coverage_earth USING rtree(id, min_x, max_x, min_y, max_y);

CREATE TRIGGER coverage_box_delete AFTER DELETE ON coverage_box BEGIN
  DELETE FROM coverage_map WHERE id = old.id;
  DELETE FROM coverage_earth WHERE id = old.id;
END;
)";

const char* const kCreateCoverageInsert = R"(
DROP TRIGGER IF EXISTS coverage_box_insert;
CREATE TRIGGER coverage_box_insert AFTER INSERT ON coverage_box BEGIN
  INSERT OR REPLACE INTO coverage_map
    VALUES (new.id, new.min_x_m, new.max_x_m, new.min_y_m, new.max_y_m);
  INSERT OR REPLACE INTO coverage_earth
    SELECT new.id, new.min_longitude_deg, new.max_longitude_deg,
           new.min_latitude_deg, new.max_latitude_deg
    WHERE new.min_longitude_deg IS NOT NULL;
END;
)";

absl::Status InsertCoverage(SqliteDatabase& database, absl::string_view map_name,
                            std::int64_t version, const std::vector<CoverageBox>& boxes) {
  for (const CoverageBox& box : boxes) {
    SqliteStatement insert(database, "INSERT INTO coverage_box VALUES (NULL,?,?,?,?,?,?,?,?,?,?)");
    insert.Bind(map_name).Bind(version);
    BindRectangle(box.map_m, &insert);
    if (box.degrees) {
      BindRectangle(*box.degrees, &insert);
    } else {
      insert.BindNull().BindNull().BindNull().BindNull();
    }
    if (absl::Status status = insert.Run(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<CoverageRecord>> FindMapCoverage(SqliteDatabase& database,
                                                            absl::string_view map_name,
                                                            const Eigen::Vector2d& p_map,
                                                            double radius_m) {
  SqliteStatement query(database,
                        "SELECT map_name, version, min_x_m, max_x_m, min_y_m, max_y_m"
                        " FROM coverage_map AS tree JOIN coverage_box AS box ON box.id = tree.id"
                        " JOIN map ON name = map_name AND active_version = version"
                        " WHERE max_x >= ? AND min_x <= ? AND max_y >= ? AND min_y <= ?"
                        " AND map_name = ?");
  BindRectangle(Around(p_map.x(), p_map.y(), radius_m, radius_m), &query);
  query.Bind(map_name);
  Nearest nearest;
  absl::Status status = Collect(
      query, radius_m, [&](const Rectangle& box) { return DistanceTo(box, p_map.x(), p_map.y()); },
      &nearest);
  if (!status.ok()) return status;
  return Records(nearest);
}

absl::StatusOr<std::vector<CoverageRecord>> FindEarthCoverage(SqliteDatabase& database,
                                                              absl::string_view prefix,
                                                              const GeodeticPosition& position,
                                                              double radius_m) {
  const double cosine = std::max(kMinCosine, std::cos(position.latitude_deg * kRadPerDeg));
  const double latitude_reach_deg = kWiden * radius_m / kDegree_m;
  const double longitude_reach_deg = std::min(180.0, latitude_reach_deg / cosine);
  Nearest nearest;
  // The date line: boxes across it go on above 180, and a place beside it is near both ends.
  for (const double turn_deg : {-360.0, 0.0, 360.0}) {
    const double longitude_deg = position.longitude_deg + turn_deg;
    SqliteStatement query(database,
                          "SELECT map_name, version, min_longitude_deg, max_longitude_deg,"
                          " min_latitude_deg, max_latitude_deg"
                          " FROM coverage_earth AS tree JOIN coverage_box AS box"
                          " ON box.id = tree.id"
                          " JOIN map ON name = map_name AND active_version = version"
                          " WHERE max_x >= ?1 AND min_x <= ?2 AND max_y >= ?3 AND min_y <= ?4"
                          " AND substr(map_name, 1, length(?5)) = ?5"
                          " AND instr(substr(map_name, length(?5) + 1), '/') = 0");
    BindRectangle(
        Around(longitude_deg, position.latitude_deg, longitude_reach_deg, latitude_reach_deg),
        &query);
    query.Bind(prefix);
    absl::Status status = Collect(
        query, radius_m,
        [&](const Rectangle& box) {
          return kDegree_m * DistanceTo(box, longitude_deg, position.latitude_deg, cosine);
        },
        &nearest);
    if (!status.ok()) return status;
  }
  return Records(nearest);
}

}  // namespace dcloc::server
