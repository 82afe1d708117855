#include "server/maps/catalogue/postgres_catalogue.h"

#include <chrono>

#include "server/maps/catalogue/catalogue_errors.h"
#include "server/maps/catalogue/coverage_search.h"
#include "server/maps/catalogue/postgres_coverage.h"
#include "server/maps/catalogue/postgres_hold_rows.h"
#include "server/maps/catalogue/postgres_rows.h"
#include "server/maps/catalogue/postgres_tables.h"
#include "server/postgres/postgres_error.h"

namespace dcloc::server {
namespace {

std::pair<std::string, std::int64_t> ReadFile(PostgresRows& row) {
  std::string sha256 = row.NextText();
  return {std::move(sha256), row.NextInteger()};
}

absl::Status EraseLooseFile(PostgresConnection& connection, absl::string_view sha256) {
  return connection.Query("DELETE FROM loose_file WHERE sha256 = $1", PostgresValues().Bind(sha256))
      .status();
}

/// In a transaction. AlreadyExists when another one has just added the same file to the map.
absl::StatusOr<MapVersionRecord> FindOrInsert(PostgresConnection& connection,
                                              const MapVersionRecord& record,
                                              const std::vector<CoverageBox>& coverage) {
  absl::Status status = LockFiles(connection, {record.sha256});
  if (!status.ok()) return status;
  absl::StatusOr<std::int64_t> version = VersionOfFile(connection, record.map_name, record.sha256);
  if (version.ok() && *version == 0) {
    version = TakeVersionNumber(connection, record.map_name);
    if (!version.ok()) return version.status();
    MapVersionRecord numbered = record;
    numbered.version = *version;
    status = InsertVersion(connection, numbered, coverage);
  }
  status.Update(version.status());
  if (status.ok()) status = EraseLooseFile(connection, record.sha256);
  if (!status.ok()) return status;
  return FindVersion(connection, record.map_name, *version);
}

/// In a transaction, with the versions locked. FailedPrecondition: one is held.
absl::Status CheckNotHeld(PostgresConnection& connection, absl::string_view map_name,
                          std::int64_t version) {
  const absl::StatusOr<std::int64_t> held = NewestHeldVersion(connection, map_name, version);
  if (!held.ok()) return held.status();
  return *held == 0 ? absl::OkStatus() : VersionInUse(map_name, *held);
}

absl::Status EraseVersion(PostgresConnection& connection, absl::string_view map_name,
                          std::int64_t version) {
  PostgresValues key;
  key.Bind(map_name).Bind(version);
  absl::Status status =
      connection.Query("DELETE FROM map_version WHERE map_name = $1 AND version = $2", key)
          .status();
  if (!status.ok()) return status;
  return connection
      .Query("UPDATE map SET previous_version = 0 WHERE name = $1 AND previous_version = $2", key)
      .status();
}

}  // namespace

PostgresCatalogue::PostgresCatalogue(std::shared_ptr<PostgresDatabase> database)
    : database_(std::move(database)),
      holds_(database_),
      maps_(*database_->watch, ChangeTopic::kCatalogue, {}),
      versions_(*database_->watch, ChangeTopic::kCatalogue, {}) {}

absl::StatusOr<std::unique_ptr<PostgresCatalogue>> PostgresCatalogue::Open(
    std::shared_ptr<PostgresDatabase> database) {
  absl::Status status = database->pool.WithConnection(&PrepareTables);
  if (!status.ok()) return status;
  return std::unique_ptr<PostgresCatalogue>(new PostgresCatalogue(std::move(database)));
}

template <typename Change>
absl::Status PostgresCatalogue::WithChange(const Change& change) {
  absl::Status status = database_->pool.InTransaction(change);
  // Also after an error: the change may have been made.
  maps_.Forget();
  versions_.Forget();
  return status;
}

absl::StatusOr<std::vector<MapRecord>> PostgresCatalogue::ListMaps(absl::string_view prefix,
                                                                   absl::string_view after_name,
                                                                   int limit) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::vector<MapRecord>> {
        absl::StatusOr<PostgresRows> rows = connection.Query(
            "SELECT * FROM map_row WHERE tenant = $1 AND name > $2 ORDER BY name LIMIT $3",
            PostgresValues().Bind(prefix).Bind(after_name).Bind(std::int64_t{limit}));
        if (!rows.ok()) return rows.status();
        return ReadAll(*rows, &ReadMap);
      });
}

absl::StatusOr<std::int64_t> PostgresCatalogue::SizeOfMaps(absl::string_view prefix) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::int64_t> {
        absl::StatusOr<PostgresRows> rows = connection.Query(
            "SELECT COALESCE(sum(size_bytes), 0)::bigint FROM"
            " (SELECT DISTINCT sha256, size_bytes FROM map_version WHERE tenant = $1) AS file",
            PostgresValues().Bind(prefix));
        if (!rows.ok()) return rows.status();
        rows->Next();
        return rows->NextInteger();
      });
}

absl::StatusOr<MapRecord> PostgresCatalogue::GetMap(absl::string_view map_name) {
  return maps_.Get(std::string(map_name), [&] {
    return database_->pool.WithConnection(
        [&](PostgresConnection& connection) { return FindMap(connection, map_name); });
  });
}

absl::StatusOr<std::vector<MapVersionRecord>> PostgresCatalogue::ListVersions(
    absl::string_view map_name, std::int64_t below_version, int limit) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::vector<MapVersionRecord>> {
        absl::StatusOr<PostgresRows> rows = connection.Query(
            "SELECT * FROM map_version_row WHERE map_name = $1 AND version < $2"
            " ORDER BY version DESC LIMIT $3",
            PostgresValues().Bind(map_name).Bind(below_version).Bind(std::int64_t{limit}));
        if (!rows.ok()) return rows.status();
        std::vector<MapVersionRecord> records = ReadAll(*rows, &ReadVersion);
        if (!records.empty()) return records;
        const absl::Status status = FindMap(connection, map_name).status();
        if (!status.ok()) return status;
        return records;
      });
}

absl::StatusOr<MapVersionRecord> PostgresCatalogue::GetVersion(absl::string_view map_name,
                                                               std::int64_t version) {
  return versions_.Get({std::string(map_name), version}, [&] {
    return database_->pool.WithConnection(
        [&](PostgresConnection& connection) { return FindVersion(connection, map_name, version); });
  });
}

absl::StatusOr<MapVersionRecord> PostgresCatalogue::AddVersion(
    absl::string_view map_name, absl::string_view sha256, const MapInfo& info,
    const std::vector<CoverageBox>& coverage) {
  const MapVersionRecord record{.map_name = std::string(map_name),
                                .sha256 = std::string(sha256),
                                .create_time = std::chrono::system_clock::now(),
                                .info = info};
  absl::StatusOr<MapVersionRecord> added;
  absl::Status status = WithChange([&](PostgresConnection& connection) {
    absl::Status held = holds_.CheckFileHold(connection, sha256);
    if (!held.ok()) return held;
    added = FindOrInsert(connection, record, coverage);
    return added.status();
  });
  if (!status.ok()) return status;
  return added;
}

absl::Status PostgresCatalogue::Activate(absl::string_view map_name, std::int64_t version) {
  return WithChange([&](PostgresConnection& connection) {
    absl::Status status = FindMap(connection, map_name, RowLock::kChange).status();
    if (status.ok()) status = FindVersion(connection, map_name, version).status();
    if (!status.ok()) return status;
    return connection
        .Query(
            "UPDATE map SET previous_version ="
            " CASE WHEN active_version = $1 THEN previous_version ELSE active_version END,"
            " canary_share = CASE WHEN canary_version = $1 THEN 0 ELSE canary_share END,"
            " canary_version = CASE WHEN canary_version = $1 THEN 0 ELSE canary_version END,"
            " active_version = $1 WHERE name = $2",
            PostgresValues().Bind(version).Bind(map_name))
        .status();
  });
}

absl::Status PostgresCatalogue::SetCanary(absl::string_view map_name, std::int64_t version,
                                          double share) {
  return WithChange([&](PostgresConnection& connection) -> absl::Status {
    const absl::StatusOr<MapRecord> map = FindMap(connection, map_name, RowLock::kChange);
    if (!map.ok()) return map.status();
    if (version != 0) {
      absl::Status status = FindVersion(connection, map_name, version).status();
      if (status.ok()) status = CheckMayBeCanary(*map, version);
      if (!status.ok()) return status;
    }
    return connection
        .Query("UPDATE map SET canary_version = $1, canary_share = $2 WHERE name = $3",
               PostgresValues().Bind(version).Bind(share).Bind(map_name))
        .status();
  });
}

bool PostgresCatalogue::Knows(absl::string_view map_name, std::int64_t version) {
  const absl::StatusOr<MapVersionRecord> active = GetVersion(map_name, 0);
  return (active.ok() && active->version == version) || GetVersion(map_name, version).ok();
}

absl::StatusOr<Hold> PostgresCatalogue::HoldVersion(absl::string_view map_name,
                                                    std::int64_t version,
                                                    absl::string_view holder) {
  absl::StatusOr<Hold> hold = holds_.HoldVersion(map_name, version, holder, /*is_known=*/false);
  if (!IsAway(hold.status()) || !Knows(map_name, version)) return hold;
  return holds_.HoldVersion(map_name, version, holder, /*is_known=*/true);
}

absl::StatusOr<Hold> PostgresCatalogue::HoldFile(absl::string_view sha256,
                                                 absl::string_view holder) {
  return holds_.HoldFile(sha256, holder);
}

absl::Status PostgresCatalogue::DeleteVersion(absl::string_view map_name, std::int64_t version) {
  if (absl::Status status = holds_.DeleteReleased(); !status.ok()) return status;
  return WithChange([&](PostgresConnection& connection) -> absl::Status {
    const absl::StatusOr<MapRecord> map = FindMap(connection, map_name, RowLock::kChange);
    if (!map.ok()) return map.status();
    const auto files = LockFilesOf(connection, map_name, version);
    if (!files.ok()) return files.status();
    if (files->empty()) return NoSuchVersion(map_name, version);
    absl::Status status = CheckMayBeDeleted(*map, version);
    if (status.ok()) status = CheckNotHeld(connection, map_name, version);
    if (status.ok()) status = LockFiles(connection, *files);
    if (status.ok()) status = EraseVersion(connection, map_name, version);
    return status.ok() ? NoteLooseFiles(connection, *files) : status;
  });
}

absl::Status PostgresCatalogue::DeleteMap(absl::string_view map_name) {
  if (absl::Status status = holds_.DeleteReleased(); !status.ok()) return status;
  return WithChange([&](PostgresConnection& connection) -> absl::Status {
    absl::Status status = FindMap(connection, map_name, RowLock::kChange).status();
    if (!status.ok()) return status;
    const auto files = LockFilesOf(connection, map_name, 0);
    if (!files.ok()) return files.status();
    status = CheckNotHeld(connection, map_name, 0);
    if (status.ok()) status = LockFiles(connection, *files);
    if (!status.ok()) return status;
    status = connection.Query("DELETE FROM map WHERE name = $1", PostgresValues().Bind(map_name))
                 .status();
    return status.ok() ? NoteLooseFiles(connection, *files) : status;
  });
}

absl::Status PostgresCatalogue::AddLooseFile(absl::string_view sha256) {
  return WithChange([&](PostgresConnection& connection) {
    return connection
        .Query("INSERT INTO loose_file VALUES ($1) ON CONFLICT DO NOTHING",
               PostgresValues().Bind(sha256))
        .status();
  });
}

absl::Status PostgresCatalogue::RemoveLooseFile(absl::string_view sha256) {
  return WithChange(
      [&](PostgresConnection& connection) { return EraseLooseFile(connection, sha256); });
}

absl::StatusOr<std::vector<std::string>> PostgresCatalogue::ListLooseFiles() {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::vector<std::string>> {
        absl::StatusOr<PostgresRows> rows = connection.QueryWhole("SELECT sha256 FROM loose_file");
        if (!rows.ok()) return rows.status();
        return TextsOf(*std::move(rows));
      });
}

absl::StatusOr<bool> PostgresCatalogue::HasFile(absl::string_view sha256) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<bool> {
        absl::StatusOr<PostgresRows> rows = connection.Query(
            "SELECT 1 FROM map_version WHERE sha256 = $1 LIMIT 1", PostgresValues().Bind(sha256));
        if (!rows.ok()) return rows.status();
        return rows->Next();
      });
}

absl::StatusOr<std::int64_t> PostgresCatalogue::SizeOfFile(absl::string_view prefix,
                                                           absl::string_view sha256) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::int64_t> {
        absl::StatusOr<PostgresRows> rows = connection.Query(
            "SELECT size_bytes FROM map_version WHERE tenant = $1 AND sha256 = $2 LIMIT 1",
            PostgresValues().Bind(prefix).Bind(sha256));
        if (!rows.ok()) return rows.status();
        return rows->Next() ? rows->NextInteger() : 0;
      });
}

absl::StatusOr<std::vector<std::pair<std::string, std::int64_t>>> PostgresCatalogue::ListFiles() {
  using Files = std::vector<std::pair<std::string, std::int64_t>>;
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<Files> {
        absl::StatusOr<PostgresRows> rows =
            connection.QueryWhole("SELECT DISTINCT sha256, size_bytes FROM map_version");
        if (!rows.ok()) return rows.status();
        return ReadAll(*rows, &ReadFile);
      });
}

absl::StatusOr<std::vector<MapVersionRecord>> PostgresCatalogue::ListUncovered() {
  // There was no schema without coverage.
  return std::vector<MapVersionRecord>();
}

absl::Status PostgresCatalogue::AddCoverage(absl::string_view map_name, std::int64_t version,
                                            const std::vector<CoverageBox>& coverage) {
  return WithChange([&](PostgresConnection& connection) {
    return InsertCoverage(connection, map_name, version, coverage);
  });
}

absl::StatusOr<std::vector<CoverageRecord>> PostgresCatalogue::FindCoverage(
    absl::string_view map_name, const Eigen::Vector2d& p_map, double radius_m) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::vector<CoverageRecord>> {
        auto records = FindMapCoverage(connection, map_name, p_map, radius_m);
        if (!records.ok() || !records->empty()) return records;
        const absl::Status status = FindMap(connection, map_name).status();
        if (!status.ok()) return status;
        return records;
      });
}

absl::StatusOr<std::vector<CoverageRecord>> PostgresCatalogue::FindCoverage(
    absl::string_view prefix, const GeodeticPosition& position, double radius_m, int limit) {
  auto records = database_->pool.WithConnection([&](PostgresConnection& connection) {
    return FindEarthCoverage(connection, prefix, position, radius_m);
  });
  if (records.ok()) KeepNearest(limit, &*records);
  return records;
}

}  // namespace dcloc::server
