#include "server/maps/catalogue/sqlite_schema.h"

#include "absl/strings/str_format.h"
#include "server/maps/catalogue/record_columns.h"
#include "server/maps/catalogue/sqlite_coverage.h"

namespace dcloc::server {
namespace {

constexpr char kCreateTables[] = R"(
CREATE TABLE map (
  name TEXT PRIMARY KEY,
  active_version INTEGER NOT NULL DEFAULT 0,
  next_version INTEGER NOT NULL,
  create_time_ns INTEGER NOT NULL,
  previous_version INTEGER NOT NULL DEFAULT 0,
  canary_version INTEGER NOT NULL DEFAULT 0,
  canary_share REAL NOT NULL DEFAULT 0
) STRICT, WITHOUT ROWID;

CREATE TABLE map_version (
  map_name TEXT NOT NULL REFERENCES map(name) ON DELETE CASCADE,
  version INTEGER NOT NULL,
  sha256 TEXT NOT NULL,
  create_time_ns INTEGER NOT NULL,
  size_bytes INTEGER NOT NULL,
  drive_name TEXT NOT NULL,
  description TEXT NOT NULL,
  keyframe_count INTEGER NOT NULL,
  point_count INTEGER NOT NULL,
  length_m REAL NOT NULL,
  min_x_m REAL NOT NULL, min_y_m REAL NOT NULL, min_z_m REAL NOT NULL,
  max_x_m REAL NOT NULL, max_y_m REAL NOT NULL, max_z_m REAL NOT NULL,
  has_elevation INTEGER NOT NULL,
  anchor_latitude_deg REAL, anchor_longitude_deg REAL, anchor_height_m REAL,
  anchor_x_axis_east_rad REAL,
  PRIMARY KEY (map_name, version),
  UNIQUE (map_name, sha256)
) STRICT, WITHOUT ROWID;

CREATE INDEX map_version_sha256 ON map_version(sha256);

CREATE VIEW map_row AS
  SELECT name, active_version,
         (SELECT COUNT(*) FROM map_version WHERE map_name = name) AS version_count, create_time_ns,
         previous_version, canary_version, canary_share
  FROM map;

CREATE VIEW map_version_row AS
  SELECT map_version.*, active_version = version AS active
  FROM map_version JOIN map ON map_name = name;
)";

constexpr char kMigrateFrom1[] = R"(
ALTER TABLE map ADD COLUMN previous_version INTEGER NOT NULL DEFAULT 0;
ALTER TABLE map ADD COLUMN canary_version INTEGER NOT NULL DEFAULT 0;
ALTER TABLE map ADD COLUMN canary_share REAL NOT NULL DEFAULT 0;

DROP VIEW map_row;
CREATE VIEW map_row AS
  SELECT name, active_version,
         (SELECT COUNT(*) FROM map_version WHERE map_name = name) AS version_count, create_time_ns,
         previous_version, canary_version, canary_share
  FROM map;
)";

/// Files that may be there without a version: they are about to be stored or removed.
constexpr char kCreateLooseFile[] = R"(
CREATE TABLE loose_file (sha256 TEXT PRIMARY KEY) STRICT, WITHOUT ROWID;
PRAGMA application_id = 0x44434C43;
PRAGMA user_version = 3;
)";

absl::StatusOr<std::int64_t> ReadNumber(SqliteDatabase& database, const char* sql) {
  SqliteStatement query(database, sql);
  const absl::StatusOr<bool> row = query.Step();
  if (!row.ok()) return row.status();
  return *row ? query.NextInteger() : 0;
}

absl::Status CheckIsOurs(SqliteDatabase& database, std::int64_t version) {
  const auto tables = ReadNumber(database, "SELECT COUNT(*) FROM sqlite_master");
  const auto ours = ReadNumber(
      database, "SELECT COUNT(*) FROM sqlite_master WHERE name IN ('map', 'map_version')");
  if (!tables.ok()) return tables.status();
  if (!ours.ok()) return ours.status();
  if (version == 0 ? *tables == 0 : *ours == 2) return absl::OkStatus();
  return absl::FailedPreconditionError("catalogue: it is a database of something else");
}

}  // namespace

absl::Status CheckSchema(SqliteDatabase& database) {
  const absl::StatusOr<std::int64_t> version = ReadNumber(database, "PRAGMA user_version");
  if (!version.ok()) return version.status();
  if (*version > kSchemaVersion || *version < 0) {
    return absl::FailedPreconditionError(
        absl::StrFormat("catalogue: its schema has version %d, from a newer program; this program "
                        "knows %d",
                        *version, kSchemaVersion));
  }
  return CheckIsOurs(database, *version);
}

absl::Status CheckSchemaIsPresent(SqliteDatabase& database) {
  absl::Status status = CheckSchema(database);
  const absl::StatusOr<std::int64_t> version = ReadNumber(database, "PRAGMA user_version");
  status.Update(version.status());
  if (!status.ok() || *version == kSchemaVersion) return status;
  return absl::FailedPreconditionError(
      absl::StrFormat("catalogue: its schema has version %d, from an earlier program; a start of "
                      "the server brings it to %d",
                      *version, kSchemaVersion));
}

absl::Status PrepareSchema(SqliteDatabase& database) {
  absl::Status status = CheckSchema(database);
  const absl::StatusOr<std::int64_t> version = ReadNumber(database, "PRAGMA user_version");
  status.Update(version.status());
  if (!status.ok() || *version == kSchemaVersion) return status;
  SqliteTransaction transaction(database);
  status = transaction.status();
  if (status.ok() && *version == 0) status = database.Run(kCreateTables);
  if (status.ok() && *version == 1) status = database.Run(kMigrateFrom1);
  if (status.ok() && *version < 2) status = database.Run(kCreateCoverage);
  if (status.ok()) status = database.Run(kCreateCoverageInsert);
  if (status.ok()) status = database.Run(kCreateLooseFile);
  return status.ok() ? transaction.Commit() : status;
}

const char* const kInsertVersion =
    "INSERT INTO map_version VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)";

MapRecord ReadMap(SqliteStatement& row) { return NextMap(row); }

MapVersionRecord ReadVersion(SqliteStatement& row) {
  MapVersionRecord record;
  record.map_name = row.NextText();
  record.version = row.NextInteger();
  record.sha256 = row.NextText();
  record.create_time = NextTime(row);
  record.info.size_bytes = static_cast<std::uint64_t>(row.NextInteger());
  record.info.name = row.NextText();
  record.info.description = row.NextText();
  record.info.keyframe_count = static_cast<std::uint64_t>(row.NextInteger());
  record.info.point_count = static_cast<std::uint64_t>(row.NextInteger());
  record.info.length_m = row.NextReal();
  record.info.min_map_m = NextVector(row);
  record.info.max_map_m = NextVector(row);
  record.info.has_elevation = row.NextInteger() != 0;
  record.info.anchor = NextAnchor(row);
  record.active = row.NextInteger() != 0;
  return record;
}

void BindVersion(const MapVersionRecord& record, SqliteStatement* insert) {
  const MapInfo& info = record.info;
  insert->Bind(record.map_name)
      .Bind(record.version)
      .Bind(record.sha256)
      .Bind(std::int64_t{record.create_time.time_since_epoch().count()})
      .Bind(static_cast<std::int64_t>(info.size_bytes))
      .Bind(info.name)
      .Bind(info.description)
      .Bind(static_cast<std::int64_t>(info.keyframe_count))
      .Bind(static_cast<std::int64_t>(info.point_count))
      .Bind(info.length_m);
  BindVector(info.min_map_m, insert);
  BindVector(info.max_map_m, insert);
  insert->Bind(std::int64_t{info.has_elevation});
  BindAnchor(info.anchor, insert);
}

}  // namespace dcloc::server
