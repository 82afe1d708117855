#include "server/maps/catalogue/sqlite_catalogue.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/maps/catalogue/sqlite_coverage.h"
#include "server/maps/catalogue/sqlite_schema.h"

namespace dcloc::server {
namespace {

absl::Status NoSuchMap(absl::string_view map_name) {
  return absl::NotFoundError(
      absl::StrCat("map_name is ", Quoted(map_name), "; there is no such map"));
}

absl::Status NoSuchVersion(absl::string_view map_name, std::int64_t version) {
  return absl::NotFoundError(
      absl::StrFormat("version is %d; map %s has no such version", version, Quoted(map_name)));
}

absl::Status InUse(absl::string_view map_name, std::int64_t version) {
  return absl::FailedPreconditionError(
      absl::StrFormat("version %d of map %s is in use; its sessions and downloads must end first",
                      version, Quoted(map_name)));
}

absl::Status CreateOrCheckSchema(SqliteDatabase& database) {
  SqliteStatement query(database, "PRAGMA user_version");
  const absl::StatusOr<bool> row = query.Step();
  if (!row.ok()) return row.status();
  const std::int64_t version = query.NextInteger();
  if (version == kSchemaVersion) return absl::OkStatus();
  if (version > kSchemaVersion || version < 0) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "catalogue: its schema has version %d; this program knows %d", version, kSchemaVersion));
  }
  SqliteTransaction transaction(database);
  if (!transaction.status().ok()) return transaction.status();
  absl::Status status = database.Run(version == 0 ? kCreateSchema : kMigrateFrom1);
  if (status.ok()) status = database.Run(kCreateCoverage);
  return status.ok() ? transaction.Commit() : status;
}

template <typename Record>
absl::StatusOr<std::vector<Record>> ReadAll(SqliteStatement& query,
                                            Record (*read)(SqliteStatement&)) {
  std::vector<Record> records;
  while (true) {
    const absl::StatusOr<bool> row = query.Step();
    if (!row.ok()) return row.status();
    if (!*row) return records;
    records.push_back(read(query));
  }
}

std::pair<std::string, std::int64_t> ReadFile(SqliteStatement& row) {
  std::string sha256 = row.NextText();
  return {std::move(sha256), row.NextInteger()};
}

}  // namespace

SqliteCatalogue::SqliteCatalogue(SqliteDatabase database) : database_(std::move(database)) {}

absl::StatusOr<std::unique_ptr<SqliteCatalogue>> SqliteCatalogue::Open(
    const std::filesystem::path& path) {
  absl::StatusOr<SqliteDatabase> database = SqliteDatabase::Open(path);
  if (!database.ok()) return database.status();
  absl::Status status = database->Run(
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON;");
  status.Update(status.ok() ? CreateOrCheckSchema(*database) : status);
  if (!status.ok()) return status;
  return std::unique_ptr<SqliteCatalogue>(new SqliteCatalogue(*std::move(database)));
}

absl::StatusOr<std::vector<MapRecord>> SqliteCatalogue::ListMaps(absl::string_view prefix,
                                                                 absl::string_view after_name,
                                                                 int limit) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_,
                        "SELECT * FROM map_row WHERE substr(name, 1, length(?1)) = ?1"
                        " AND instr(substr(name, length(?1) + 1), '/') = 0"
                        " AND name > ?2 ORDER BY name LIMIT ?3");
  query.Bind(prefix).Bind(after_name).Bind(std::int64_t{limit});
  return ReadAll(query, ReadMap);
}

absl::StatusOr<std::int64_t> SqliteCatalogue::SizeOfMaps(absl::string_view prefix) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_,
                        "SELECT COALESCE(SUM(size_bytes), 0) FROM"
                        " (SELECT DISTINCT sha256, size_bytes FROM map_version"
                        " WHERE substr(map_name, 1, length(?1)) = ?1"
                        " AND instr(substr(map_name, length(?1) + 1), '/') = 0)");
  const absl::StatusOr<bool> row = query.Bind(prefix).Step();
  if (!row.ok()) return row.status();
  return query.NextInteger();
}

absl::StatusOr<MapRecord> SqliteCatalogue::GetMap(absl::string_view map_name) {
  const std::lock_guard lock(mutex_);
  return FindMap(map_name);
}

absl::StatusOr<std::vector<MapVersionRecord>> SqliteCatalogue::ListVersions(
    absl::string_view map_name, std::int64_t below_version, int limit) {
  const std::lock_guard lock(mutex_);
  if (absl::Status status = FindMap(map_name).status(); !status.ok()) return status;
  SqliteStatement query(database_,
                        "SELECT * FROM map_version_row WHERE map_name = ? AND version < ?"
                        " ORDER BY version DESC LIMIT ?");
  query.Bind(map_name).Bind(below_version).Bind(std::int64_t{limit});
  return ReadAll(query, ReadVersion);
}

absl::StatusOr<MapVersionRecord> SqliteCatalogue::GetVersion(absl::string_view map_name,
                                                             std::int64_t version) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<MapRecord> map = FindMap(map_name);
  if (!map.ok()) return map.status();
  if (version == 0 && map->active_version == 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("map ", Quoted(map_name), " has no active version"));
  }
  return FindVersion(map_name, version == 0 ? map->active_version : version);
}

absl::StatusOr<MapVersionRecord> SqliteCatalogue::AddVersion(
    absl::string_view map_name, absl::string_view sha256, const MapInfo& info,
    const std::vector<CoverageBox>& coverage) {
  const std::lock_guard lock(mutex_);
  SqliteTransaction transaction(database_);
  if (!transaction.status().ok()) return transaction.status();
  absl::StatusOr<std::int64_t> version = VersionOfFile(map_name, sha256);
  if (!version.ok()) return version.status();
  if (*version == 0) {
    version = TakeNumber(map_name);
    if (!version.ok()) return version.status();
    SqliteStatement insert(database_, kInsertVersion);
    BindVersion({.map_name = std::string(map_name),
                 .version = *version,
                 .sha256 = std::string(sha256),
                 .create_time = std::chrono::system_clock::now(),
                 .info = info},
                &insert);
    absl::Status status = insert.Run();
    if (status.ok()) status = InsertCoverage(database_, map_name, *version, coverage);
    if (!status.ok()) return status;
  }
  if (absl::Status status = transaction.Commit(); !status.ok()) return status;
  return FindVersion(map_name, *version);
}

absl::Status SqliteCatalogue::Activate(absl::string_view map_name, std::int64_t version) {
  const std::lock_guard lock(mutex_);
  absl::Status status = FindMap(map_name).status();
  if (status.ok()) status = FindVersion(map_name, version).status();
  if (!status.ok()) return status;
  SqliteStatement update(
      database_,
      "UPDATE map SET"
      " previous_version = iif(active_version = ?1, previous_version, active_version),"
      " canary_share = iif(canary_version = ?1, 0, canary_share),"
      " canary_version = iif(canary_version = ?1, 0, canary_version),"
      " active_version = ?1 WHERE name = ?2");
  return update.Bind(version).Bind(map_name).Run();
}

absl::Status SqliteCatalogue::SetCanary(absl::string_view map_name, std::int64_t version,
                                        double share) {
  const std::lock_guard lock(mutex_);
  absl::Status status = FindMap(map_name).status();
  if (status.ok() && version != 0) {
    const absl::StatusOr<MapVersionRecord> record = FindVersion(map_name, version);
    if (!record.ok()) return record.status();
    if (record->active) {
      return absl::FailedPreconditionError(absl::StrFormat(
          "version is %d; it is the active one of map %s", version, Quoted(map_name)));
    }
  }
  if (!status.ok()) return status;
  SqliteStatement update(database_,
                         "UPDATE map SET canary_version = ?, canary_share = ? WHERE name = ?");
  return update.Bind(version).Bind(share).Bind(map_name).Run();
}

absl::StatusOr<Hold> SqliteCatalogue::HoldVersion(absl::string_view map_name, std::int64_t version,
                                                  absl::string_view /*holder*/) {
  const std::lock_guard lock(mutex_);
  absl::Status status = FindMap(map_name).status();
  if (status.ok()) status = FindVersion(map_name, version).status();
  if (!status.ok()) return status;
  return holds_.HoldVersion(map_name, version);
}

absl::StatusOr<Hold> SqliteCatalogue::HoldFile(absl::string_view sha256, absl::string_view holder) {
  return holds_.HoldFile(sha256, holder);
}

absl::Status SqliteCatalogue::DeleteVersion(absl::string_view map_name, std::int64_t version) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<MapRecord> map = FindMap(map_name);
  if (!map.ok()) return map.status();
  const absl::StatusOr<MapVersionRecord> record = FindVersion(map_name, version);
  if (!record.ok()) return record.status();
  if (holds_.IsHeld(map_name, version)) return InUse(map_name, version);
  if (map->canary_version == version) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "version %d of map %s is the canary; set another one or none", version, Quoted(map_name)));
  }
  if (record->active) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "version %d of map %s is active; activate another one or delete the whole map", version,
        Quoted(map_name)));
  }
  SqliteTransaction transaction(database_);
  if (!transaction.status().ok()) return transaction.status();
  SqliteStatement remove(database_, "DELETE FROM map_version WHERE map_name = ? AND version = ?");
  absl::Status status = remove.Bind(map_name).Bind(version).Run();
  SqliteStatement forget(
      database_, "UPDATE map SET previous_version = 0 WHERE name = ? AND previous_version = ?");
  if (status.ok()) status = forget.Bind(map_name).Bind(version).Run();
  return status.ok() ? transaction.Commit() : status;
}

absl::Status SqliteCatalogue::DeleteMap(absl::string_view map_name) {
  const std::lock_guard lock(mutex_);
  if (const auto version = holds_.NewestHeld(map_name)) return InUse(map_name, *version);
  SqliteStatement remove(database_, "DELETE FROM map WHERE name = ?");
  if (absl::Status status = remove.Bind(map_name).Run(); !status.ok()) return status;
  return database_.ChangedRowCount() == 0 ? NoSuchMap(map_name) : absl::OkStatus();
}

absl::StatusOr<bool> SqliteCatalogue::HasFile(absl::string_view sha256) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_, "SELECT 1 FROM map_version WHERE sha256 = ? LIMIT 1");
  return query.Bind(sha256).Step();
}

absl::StatusOr<std::int64_t> SqliteCatalogue::SizeOfFile(absl::string_view prefix,
                                                         absl::string_view sha256) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_,
                        "SELECT size_bytes FROM map_version WHERE sha256 = ?2"
                        " AND substr(map_name, 1, length(?1)) = ?1"
                        " AND instr(substr(map_name, length(?1) + 1), '/') = 0 LIMIT 1");
  const absl::StatusOr<bool> row = query.Bind(prefix).Bind(sha256).Step();
  if (!row.ok()) return row.status();
  return *row ? query.NextInteger() : 0;
}

absl::StatusOr<std::vector<std::pair<std::string, std::int64_t>>> SqliteCatalogue::ListFiles() {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_, "SELECT DISTINCT sha256, size_bytes FROM map_version");
  return ReadAll(query, ReadFile);
}

absl::StatusOr<std::vector<MapVersionRecord>> SqliteCatalogue::ListUncovered() {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_,
                        "SELECT * FROM map_version_row AS row WHERE NOT EXISTS"
                        " (SELECT 1 FROM coverage_box AS box WHERE box.map_name = row.map_name"
                        " AND box.version = row.version)");
  return ReadAll(query, ReadVersion);
}

absl::Status SqliteCatalogue::AddCoverage(absl::string_view map_name, std::int64_t version,
                                          const std::vector<CoverageBox>& coverage) {
  const std::lock_guard lock(mutex_);
  SqliteTransaction transaction(database_);
  if (!transaction.status().ok()) return transaction.status();
  absl::Status status = InsertCoverage(database_, map_name, version, coverage);
  return status.ok() ? transaction.Commit() : status;
}

absl::StatusOr<std::vector<CoverageRecord>> SqliteCatalogue::FindCoverage(
    absl::string_view map_name, const Eigen::Vector2d& p_map, double radius_m) {
  const std::lock_guard lock(mutex_);
  if (absl::Status status = FindMap(map_name).status(); !status.ok()) return status;
  return FindMapCoverage(database_, map_name, p_map, radius_m);
}

absl::StatusOr<std::vector<CoverageRecord>> SqliteCatalogue::FindCoverage(
    absl::string_view prefix, const GeodeticPosition& position, double radius_m, int limit) {
  const std::lock_guard lock(mutex_);
  absl::StatusOr<std::vector<CoverageRecord>> records =
      FindEarthCoverage(database_, prefix, position, radius_m);
  if (!records.ok()) return records;
  std::ranges::stable_sort(*records, {}, &CoverageRecord::distance_m);
  if (static_cast<int>(records->size()) > limit) {
    records->resize(static_cast<std::size_t>(limit));
  }
  return records;
}

absl::StatusOr<MapRecord> SqliteCatalogue::FindMap(absl::string_view map_name) {
  SqliteStatement query(database_, "SELECT * FROM map_row WHERE name = ?");
  const absl::StatusOr<bool> row = query.Bind(map_name).Step();
  if (!row.ok()) return row.status();
  if (!*row) return NoSuchMap(map_name);
  return ReadMap(query);
}

absl::StatusOr<MapVersionRecord> SqliteCatalogue::FindVersion(absl::string_view map_name,
                                                              std::int64_t version) {
  SqliteStatement query(database_,
                        "SELECT * FROM map_version_row WHERE map_name = ? AND version = ?");
  const absl::StatusOr<bool> row = query.Bind(map_name).Bind(version).Step();
  if (!row.ok()) return row.status();
  if (!*row) return NoSuchVersion(map_name, version);
  return ReadVersion(query);
}

absl::StatusOr<std::int64_t> SqliteCatalogue::VersionOfFile(absl::string_view map_name,
                                                            absl::string_view sha256) {
  SqliteStatement query(database_,
                        "SELECT version FROM map_version WHERE map_name = ? AND sha256 = ?");
  const absl::StatusOr<bool> row = query.Bind(map_name).Bind(sha256).Step();
  if (!row.ok()) return row.status();
  return *row ? query.NextInteger() : 0;
}

absl::StatusOr<std::int64_t> SqliteCatalogue::TakeNumber(absl::string_view map_name) {
  SqliteStatement upsert(database_,
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
