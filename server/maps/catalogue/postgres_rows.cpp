#include "server/maps/catalogue/postgres_rows.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/maps/catalogue/catalogue_errors.h"
#include "server/maps/catalogue/postgres_coverage.h"
#include "server/maps/catalogue/postgres_tables.h"
#include "server/postgres/advisory_lock.h"

namespace dcloc::server {

absl::StatusOr<MapRecord> FindMap(PostgresConnection& connection, absl::string_view map_name,
                                  RowLock lock) {
  PostgresValues name;
  name.Bind(map_name);
  if (lock == RowLock::kChange) {
    absl::StatusOr<PostgresRows> locked =
        connection.Query("SELECT 1 FROM map WHERE name = $1 FOR NO KEY UPDATE", name);
    if (!locked.ok()) return locked.status();
  }
  absl::StatusOr<PostgresRows> rows =
      connection.Query("SELECT * FROM map_row WHERE name = $1", name);
  if (!rows.ok()) return rows.status();
  if (!rows->Next()) return NoSuchMap(map_name);
  return ReadMap(*rows);
}

absl::StatusOr<MapVersionRecord> FindVersion(PostgresConnection& connection,
                                             absl::string_view map_name, std::int64_t version) {
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "SELECT * FROM map_version_row WHERE map_name = $1"
      " AND CASE WHEN $2::bigint = 0 THEN active ELSE version = $2::bigint END",
      PostgresValues().Bind(map_name).Bind(version));
  if (!rows.ok()) return rows.status();
  if (rows->Next()) return ReadVersion(*rows);
  const absl::StatusOr<MapRecord> map = FindMap(connection, map_name);
  if (!map.ok()) return map.status();
  return version == 0 ? NoActiveVersion(map_name) : NoSuchVersion(map_name, version);
}

absl::StatusOr<std::int64_t> VersionOfFile(PostgresConnection& connection,
                                           absl::string_view map_name, absl::string_view sha256) {
  absl::StatusOr<PostgresRows> rows =
      connection.Query("SELECT version FROM map_version WHERE map_name = $1 AND sha256 = $2",
                       PostgresValues().Bind(map_name).Bind(sha256));
  if (!rows.ok()) return rows.status();
  return rows->Next() ? rows->NextInteger() : 0;
}

absl::StatusOr<std::int64_t> TakeVersionNumber(PostgresConnection& connection,
                                               absl::string_view map_name) {
  const SystemTime now = std::chrono::system_clock::now();
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "INSERT INTO map (name, next_version, create_time_ns) VALUES ($1, 2, $2)"
      " ON CONFLICT (name) DO UPDATE SET next_version = map.next_version + 1"
      " RETURNING next_version - 1",
      PostgresValues().Bind(map_name).Bind(std::int64_t{now.time_since_epoch().count()}));
  if (!rows.ok()) return rows.status();
  rows->Next();
  return rows->NextInteger();
}

absl::Status InsertVersion(PostgresConnection& connection, const MapVersionRecord& record,
                           const std::vector<CoverageBox>& coverage) {
  PostgresValues values;
  BindVersion(record, &values);
  absl::Status status = connection.Query(kInsertPostgresVersion, values).status();
  if (!status.ok()) return status;
  return InsertCoverage(connection, record.map_name, record.version, coverage);
}

absl::StatusOr<std::vector<std::string>> LockFilesOf(PostgresConnection& connection,
                                                     absl::string_view map_name,
                                                     std::int64_t version) {
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "SELECT sha256 FROM map_version WHERE map_name = $1"
      " AND ($2::bigint = 0 OR version = $2::bigint) ORDER BY version FOR UPDATE",
      PostgresValues().Bind(map_name).Bind(version));
  if (!rows.ok()) return rows.status();
  return TextsOf(*std::move(rows));
}

absl::Status LockFiles(PostgresConnection& connection, std::vector<std::string> files) {
  std::ranges::sort(files);  // in one order, or two could wait for each other
  const std::string lock =
      absl::StrCat("SELECT pg_advisory_xact_lock(hashtextextended($1, ", kAdvisoryLock, "))");
  for (const std::string& sha256 : files) {
    absl::Status status = connection.Query(lock.c_str(), PostgresValues().Bind(sha256)).status();
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status NoteLooseFiles(PostgresConnection& connection, const std::vector<std::string>& files) {
  for (const std::string& sha256 : files) {
    absl::Status status =
        connection
            .Query(
                "INSERT INTO loose_file SELECT $1::text WHERE NOT EXISTS"
                " (SELECT 1 FROM map_version WHERE sha256 = $1) ON CONFLICT DO NOTHING",
                PostgresValues().Bind(sha256))
            .status();
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

std::vector<std::string> TextsOf(PostgresRows rows) {
  std::vector<std::string> texts;
  while (rows.Next()) texts.push_back(rows.NextText());
  return texts;
}

}  // namespace dcloc::server
