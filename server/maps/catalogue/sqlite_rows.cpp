#include "server/maps/catalogue/sqlite_rows.h"

#include "server/maps/catalogue/catalogue_errors.h"
#include "server/maps/catalogue/sqlite_schema.h"

namespace dcloc::server {

absl::StatusOr<MapRecord> FindMap(SqliteDatabase& database, absl::string_view map_name) {
  SqliteStatement query(database, "SELECT * FROM map_row WHERE name = ?");
  const absl::StatusOr<bool> row = query.Bind(map_name).Step();
  if (!row.ok()) return row.status();
  if (!*row) return NoSuchMap(map_name);
  return ReadMap(query);
}

absl::StatusOr<MapVersionRecord> FindVersion(SqliteDatabase& database, absl::string_view map_name,
                                             std::int64_t version) {
  SqliteStatement query(database,
                        "SELECT * FROM map_version_row WHERE map_name = ? AND version = ?");
  const absl::StatusOr<bool> row = query.Bind(map_name).Bind(version).Step();
  if (!row.ok()) return row.status();
  if (*row) return ReadVersion(query);
  return NoSuchVersion(map_name, version);
}

absl::StatusOr<std::int64_t> VersionOfFile(SqliteDatabase& database, absl::string_view map_name,
                                           absl::string_view sha256) {
  SqliteStatement query(database,
                        "SELECT version FROM map_version WHERE map_name = ? AND sha256 = ?");
  const absl::StatusOr<bool> row = query.Bind(map_name).Bind(sha256).Step();
  if (!row.ok()) return row.status();
  return *row ? query.NextInteger() : 0;
}

absl::StatusOr<bool> HasVersionOfFile(SqliteDatabase& database, absl::string_view sha256) {
  SqliteStatement query(database, "SELECT 1 FROM map_version WHERE sha256 = ? LIMIT 1");
  return query.Bind(sha256).Step();
}

absl::StatusOr<std::int64_t> TakeVersionNumber(SqliteDatabase& database,
                                               absl::string_view map_name) {
  SqliteStatement upsert(database,
                         "INSERT INTO map (name, next_version, create_time_ns) VALUES (?, 2, ?)"
                         " ON CONFLICT (name) DO UPDATE SET next_version = next_version + 1"
                         " RETURNING next_version - 1");
  const SystemTime now = std::chrono::system_clock::now();
  const absl::StatusOr<bool> row =
      upsert.Bind(map_name).Bind(std::int64_t{now.time_since_epoch().count()}).Step();
  if (!row.ok()) return row.status();
  return upsert.NextInteger();
}

}  // namespace dcloc::server
