#include "server/maps/catalogue/sqlite_coverage.h"

#include <string>
#include <utility>

#include "server/maps/catalogue/coverage_search.h"
#include "server/maps/catalogue/record_columns.h"

namespace dcloc::server {
namespace {

void BindRectangle(const Rectangle& rectangle, SqliteStatement* statement) {
  statement->Bind(rectangle.min_x)
      .Bind(rectangle.max_x)
      .Bind(rectangle.min_y)
      .Bind(rectangle.max_y);
}

/// Goes through boxes and notes how far each is.
template <typename Distance>
absl::Status Collect(SqliteStatement& query, const Distance& distance, NearestVersions* nearest) {
  while (true) {
    const absl::StatusOr<bool> row = query.Step();
    if (!row.ok()) return row.status();
    if (!*row) return absl::OkStatus();
    std::string map_name = query.NextText();
    const std::int64_t version = query.NextInteger();
    nearest->Add(std::move(map_name), version, distance(NextRectangle(query)));
  }
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
  NearestVersions nearest(radius_m);
  absl::Status status = Collect(
      query, [&](const Rectangle& box) { return DistanceTo(box, p_map.x(), p_map.y()); }, &nearest);
  if (!status.ok()) return status;
  return nearest.Records();
}

absl::StatusOr<std::vector<CoverageRecord>> FindEarthCoverage(SqliteDatabase& database,
                                                              absl::string_view prefix,
                                                              const GeodeticPosition& position,
                                                              double radius_m) {
  NearestVersions nearest(radius_m);
  for (const EarthWindow& window : EarthWindows(position, radius_m)) {
    SqliteStatement query(database,
                          "SELECT map_name, version, min_longitude_deg, max_longitude_deg,"
                          " min_latitude_deg, max_latitude_deg"
                          " FROM coverage_earth AS tree JOIN coverage_box AS box"
                          " ON box.id = tree.id"
                          " JOIN map ON name = map_name AND active_version = version"
                          " WHERE max_x >= ?1 AND min_x <= ?2 AND max_y >= ?3 AND min_y <= ?4"
                          " AND substr(map_name, 1, length(?5)) = ?5"
                          " AND instr(substr(map_name, length(?5) + 1), '/') = 0");
    BindRectangle(window.reach, &query);
    query.Bind(prefix);
    absl::Status status = Collect(
        query, [&](const Rectangle& box) { return window.DistanceTo_m(box); }, &nearest);
    if (!status.ok()) return status;
  }
  return nearest.Records();
}

}  // namespace dcloc::server
