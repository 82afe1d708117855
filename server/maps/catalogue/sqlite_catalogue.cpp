#include "server/maps/catalogue/sqlite_catalogue.h"

#include "server/maps/catalogue/catalogue_errors.h"
#include "server/maps/catalogue/coverage_search.h"
#include "server/maps/catalogue/sqlite_coverage.h"
#include "server/maps/catalogue/sqlite_rows.h"
#include "server/maps/catalogue/sqlite_schema.h"

namespace dcloc::server {
namespace {

/// In WAL mode a reader waits for nobody, unless another program takes the whole file.
constexpr std::chrono::milliseconds kReadBusyTimeout{100};

std::pair<std::string, std::int64_t> ReadFile(SqliteStatement& row) {
  std::string sha256 = row.NextText();
  return {std::move(sha256), row.NextInteger()};
}

std::string ReadText(SqliteStatement& row) { return row.NextText(); }

absl::Status InsertVersion(SqliteDatabase& database, const MapVersionRecord& record,
                           const std::vector<CoverageBox>& coverage) {
  SqliteStatement insert(database, kInsertVersion);
  BindVersion(record, &insert);
  absl::Status status = insert.Run();
  if (status.ok()) status = InsertCoverage(database, record.map_name, record.version, coverage);
  return status;
}

absl::Status InsertLooseFile(SqliteDatabase& database, absl::string_view sha256) {
  SqliteStatement insert(database, "INSERT OR IGNORE INTO loose_file VALUES (?)");
  return insert.Bind(sha256).Run();
}

absl::Status EraseLooseFile(SqliteDatabase& database, absl::string_view sha256) {
  SqliteStatement erase(database, "DELETE FROM loose_file WHERE sha256 = ?");
  return erase.Bind(sha256).Run();
}

/// Of files that versions had a moment ago.
absl::Status NoteLooseFiles(SqliteDatabase& database, const std::vector<std::string>& files) {
  for (const std::string& sha256 : files) {
    const absl::StatusOr<bool> needed = HasVersionOfFile(database, sha256);
    absl::Status status = needed.status();
    if (status.ok() && !*needed) status = InsertLooseFile(database, sha256);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<MapVersionRecord> ReadVersionOrActive(SqliteDatabase& database,
                                                     absl::string_view map_name,
                                                     std::int64_t version) {
  const absl::StatusOr<MapRecord> map = FindMap(database, map_name);
  if (!map.ok()) return map.status();
  if (version == 0 && map->active_version == 0) return NoActiveVersion(map_name);
  return FindVersion(database, map_name, version == 0 ? map->active_version : version);
}

}  // namespace

SqliteCatalogue::SqliteCatalogue(SqliteDatabase writer, SqliteDatabase reader)
    : writer_(std::move(writer)), reader_(std::move(reader)) {}

absl::StatusOr<std::unique_ptr<SqliteCatalogue>> SqliteCatalogue::Open(
    const std::filesystem::path& path) {
  absl::StatusOr<SqliteDatabase> writer = SqliteDatabase::Open(path);
  if (!writer.ok()) return writer.status();
  // Before anything is changed: it may be another program's.
  absl::Status status = CheckSchema(*writer);
  if (status.ok()) {
    status = writer->Run(
        "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON;");
  }
  if (status.ok()) status = PrepareSchema(*writer);
  if (!status.ok()) return status;
  absl::StatusOr<SqliteDatabase> reader =
      SqliteDatabase::Open(path, SqliteAccess::kRead, kReadBusyTimeout);
  if (!reader.ok()) return reader.status();
  return std::unique_ptr<SqliteCatalogue>(
      new SqliteCatalogue(*std::move(writer), *std::move(reader)));
}

absl::StatusOr<std::unique_ptr<SqliteCatalogue>> SqliteCatalogue::OpenToRead(
    const std::filesystem::path& path) {
  absl::StatusOr<SqliteDatabase> writer = SqliteDatabase::Open(path, SqliteAccess::kRead);
  if (!writer.ok()) return writer.status();
  if (absl::Status status = CheckSchemaIsPresent(*writer); !status.ok()) return status;
  absl::StatusOr<SqliteDatabase> reader = SqliteDatabase::Open(path, SqliteAccess::kRead);
  if (!reader.ok()) return reader.status();
  return std::unique_ptr<SqliteCatalogue>(
      new SqliteCatalogue(*std::move(writer), *std::move(reader)));
}

template <typename Read>
auto SqliteCatalogue::WithReader(const Read& read)
    -> decltype(read(std::declval<SqliteDatabase&>())) {
  const std::lock_guard lock(read_mutex_);
  const SqliteSnapshot snapshot(reader_);
  if (!snapshot.status().ok()) return snapshot.status();
  return read(reader_);
}

template <typename Change>
absl::Status SqliteCatalogue::WithWriter(const Change& change) {
  const std::lock_guard lock(write_mutex_);
  SqliteTransaction transaction(writer_);
  absl::Status status = transaction.status();
  if (status.ok()) status = change(writer_);
  return status.ok() ? transaction.Commit() : status;
}

absl::StatusOr<std::vector<MapRecord>> SqliteCatalogue::ListMaps(absl::string_view prefix,
                                                                 absl::string_view after_name,
                                                                 int limit) {
  return WithReader([&](SqliteDatabase& database) {
    SqliteStatement query(database,
                          "SELECT * FROM map_row WHERE substr(name, 1, length(?1)) = ?1"
                          " AND instr(substr(name, length(?1) + 1), '/') = 0"
                          " AND name > ?2 ORDER BY name LIMIT ?3");
    query.Bind(prefix).Bind(after_name).Bind(std::int64_t{limit});
    return ReadAll(query, ReadMap);
  });
}

absl::StatusOr<std::int64_t> SqliteCatalogue::SizeOfMaps(absl::string_view prefix) {
  return WithReader([&](SqliteDatabase& database) -> absl::StatusOr<std::int64_t> {
    SqliteStatement query(database,
                          "SELECT COALESCE(SUM(size_bytes), 0) FROM"
                          " (SELECT DISTINCT sha256, size_bytes FROM map_version"
                          " WHERE substr(map_name, 1, length(?1)) = ?1"
                          " AND instr(substr(map_name, length(?1) + 1), '/') = 0)");
    const absl::StatusOr<bool> row = query.Bind(prefix).Step();
    if (!row.ok()) return row.status();
    return query.NextInteger();
  });
}

absl::StatusOr<MapRecord> SqliteCatalogue::GetMap(absl::string_view map_name) {
  return WithReader([&](SqliteDatabase& database) { return FindMap(database, map_name); });
}

absl::StatusOr<std::vector<MapVersionRecord>> SqliteCatalogue::ListVersions(
    absl::string_view map_name, std::int64_t below_version, int limit) {
  return WithReader([&](SqliteDatabase& database) -> absl::StatusOr<std::vector<MapVersionRecord>> {
    absl::Status status = FindMap(database, map_name).status();
    if (!status.ok()) return status;
    SqliteStatement query(database,
                          "SELECT * FROM map_version_row WHERE map_name = ? AND version < ?"
                          " ORDER BY version DESC LIMIT ?");
    query.Bind(map_name).Bind(below_version).Bind(std::int64_t{limit});
    return ReadAll(query, ReadVersion);
  });
}

absl::StatusOr<MapVersionRecord> SqliteCatalogue::GetVersion(absl::string_view map_name,
                                                             std::int64_t version) {
  return WithReader(
      [&](SqliteDatabase& database) { return ReadVersionOrActive(database, map_name, version); });
}

absl::StatusOr<MapVersionRecord> SqliteCatalogue::AddVersion(
    absl::string_view map_name, absl::string_view sha256, const MapInfo& info,
    const std::vector<CoverageBox>& coverage) {
  absl::StatusOr<MapVersionRecord> added;
  absl::Status status = WithWriter([&](SqliteDatabase& database) {
    absl::StatusOr<std::int64_t> version = VersionOfFile(database, map_name, sha256);
    absl::Status result = version.status();
    if (result.ok() && *version == 0) {
      version = TakeVersionNumber(database, map_name);
      result = version.status();
      if (!result.ok()) return result;
      result = InsertVersion(database,
                             {.map_name = std::string(map_name),
                              .version = *version,
                              .sha256 = std::string(sha256),
                              .create_time = std::chrono::system_clock::now(),
                              .info = info},
                             coverage);
    }
    if (result.ok()) result = EraseLooseFile(database, sha256);
    if (!result.ok()) return result;
    added = FindVersion(database, map_name, *version);
    return added.status();
  });
  if (!status.ok()) return status;
  return added;
}

absl::Status SqliteCatalogue::Activate(absl::string_view map_name, std::int64_t version) {
  return WithWriter([&](SqliteDatabase& database) {
    absl::Status status = FindMap(database, map_name).status();
    if (status.ok()) status = FindVersion(database, map_name, version).status();
    if (!status.ok()) return status;
    SqliteStatement update(
        database,
        "UPDATE map SET"
        " previous_version = iif(active_version = ?1, previous_version, active_version),"
        " canary_share = iif(canary_version = ?1, 0, canary_share),"
        " canary_version = iif(canary_version = ?1, 0, canary_version),"
        " active_version = ?1 WHERE name = ?2");
    return update.Bind(version).Bind(map_name).Run();
  });
}

absl::Status SqliteCatalogue::SetCanary(absl::string_view map_name, std::int64_t version,
                                        double share) {
  return WithWriter([&](SqliteDatabase& database) -> absl::Status {
    const absl::StatusOr<MapRecord> map = FindMap(database, map_name);
    if (!map.ok()) return map.status();
    if (version != 0) {
      absl::Status status = FindVersion(database, map_name, version).status();
      if (status.ok()) status = CheckMayBeCanary(*map, version);
      if (!status.ok()) return status;
    }
    SqliteStatement update(database,
                           "UPDATE map SET canary_version = ?, canary_share = ? WHERE name = ?");
    return update.Bind(version).Bind(share).Bind(map_name).Run();
  });
}

absl::StatusOr<Hold> SqliteCatalogue::HoldVersion(absl::string_view map_name, std::int64_t version,
                                                  absl::string_view /*holder*/) {
  // First the hold, then the look: what is there once it is held is not deleted any more.
  absl::StatusOr<Hold> hold = holds_.HoldVersion(map_name, version);
  if (!hold.ok()) return hold;
  absl::Status status = WithReader([&](SqliteDatabase& database) {
    absl::Status found = FindMap(database, map_name).status();
    return found.ok() ? FindVersion(database, map_name, version).status() : found;
  });
  if (!status.ok()) return status;
  return hold;
}

absl::StatusOr<Hold> SqliteCatalogue::HoldFile(absl::string_view sha256, absl::string_view holder) {
  return holds_.HoldFile(sha256, holder);
}

absl::Status SqliteCatalogue::DeleteVersion(absl::string_view map_name, std::int64_t version) {
  absl::StatusOr<Hold> bar;  // until it is deleted or not
  return WithWriter([&](SqliteDatabase& database) -> absl::Status {
    const absl::StatusOr<MapRecord> map = FindMap(database, map_name);
    if (!map.ok()) return map.status();
    const absl::StatusOr<MapVersionRecord> record = FindVersion(database, map_name, version);
    if (!record.ok()) return record.status();
    absl::Status status = CheckMayBeDeleted(*map, version);
    if (!status.ok()) return status;
    bar = holds_.BarVersion(map_name, version);
    if (!bar.ok()) return bar.status();
    SqliteStatement remove(database, "DELETE FROM map_version WHERE map_name = ? AND version = ?");
    status = remove.Bind(map_name).Bind(version).Run();
    SqliteStatement forget(
        database, "UPDATE map SET previous_version = 0 WHERE name = ? AND previous_version = ?");
    if (status.ok()) status = forget.Bind(map_name).Bind(version).Run();
    return status.ok() ? NoteLooseFiles(database, {record->sha256}) : status;
  });
}

absl::Status SqliteCatalogue::DeleteMap(absl::string_view map_name) {
  absl::StatusOr<Hold> bar;
  return WithWriter([&](SqliteDatabase& database) -> absl::Status {
    absl::Status status = FindMap(database, map_name).status();
    if (!status.ok()) return status;
    bar = holds_.BarMap(map_name);
    if (!bar.ok()) return bar.status();
    SqliteStatement query(database, "SELECT sha256 FROM map_version WHERE map_name = ?");
    const absl::StatusOr<std::vector<std::string>> files = ReadAll(query.Bind(map_name), ReadText);
    if (!files.ok()) return files.status();
    SqliteStatement remove(database, "DELETE FROM map WHERE name = ?");
    status = remove.Bind(map_name).Run();
    return status.ok() ? NoteLooseFiles(database, *files) : status;
  });
}

absl::Status SqliteCatalogue::AddLooseFile(absl::string_view sha256) {
  return WithWriter([&](SqliteDatabase& database) { return InsertLooseFile(database, sha256); });
}

absl::Status SqliteCatalogue::RemoveLooseFile(absl::string_view sha256) {
  return WithWriter([&](SqliteDatabase& database) { return EraseLooseFile(database, sha256); });
}

absl::StatusOr<std::vector<std::string>> SqliteCatalogue::ListLooseFiles() {
  return WithReader([&](SqliteDatabase& database) {
    SqliteStatement query(database, "SELECT sha256 FROM loose_file");
    return ReadAll(query, ReadText);
  });
}

absl::StatusOr<bool> SqliteCatalogue::HasFile(absl::string_view sha256) {
  return WithReader([&](SqliteDatabase& database) { return HasVersionOfFile(database, sha256); });
}

absl::StatusOr<std::int64_t> SqliteCatalogue::SizeOfFile(absl::string_view prefix,
                                                         absl::string_view sha256) {
  return WithReader([&](SqliteDatabase& database) -> absl::StatusOr<std::int64_t> {
    SqliteStatement query(database,
                          "SELECT size_bytes FROM map_version WHERE sha256 = ?2"
                          " AND substr(map_name, 1, length(?1)) = ?1"
                          " AND instr(substr(map_name, length(?1) + 1), '/') = 0 LIMIT 1");
    const absl::StatusOr<bool> row = query.Bind(prefix).Bind(sha256).Step();
    if (!row.ok()) return row.status();
    return *row ? query.NextInteger() : 0;
  });
}

absl::StatusOr<std::vector<std::pair<std::string, std::int64_t>>> SqliteCatalogue::ListFiles() {
  return WithReader([&](SqliteDatabase& database) {
    SqliteStatement query(database, "SELECT DISTINCT sha256, size_bytes FROM map_version");
    return ReadAll(query, ReadFile);
  });
}

absl::StatusOr<std::vector<MapVersionRecord>> SqliteCatalogue::ListUncovered() {
  return WithReader([&](SqliteDatabase& database) {
    SqliteStatement query(database,
                          "SELECT * FROM map_version_row AS row WHERE NOT EXISTS"
                          " (SELECT 1 FROM coverage_box AS box WHERE box.map_name = row.map_name"
                          " AND box.version = row.version)");
    return ReadAll(query, ReadVersion);
  });
}

absl::Status SqliteCatalogue::AddCoverage(absl::string_view map_name, std::int64_t version,
                                          const std::vector<CoverageBox>& coverage) {
  return WithWriter([&](SqliteDatabase& database) {
    return InsertCoverage(database, map_name, version, coverage);
  });
}

absl::StatusOr<std::vector<CoverageRecord>> SqliteCatalogue::FindCoverage(
    absl::string_view map_name, const Eigen::Vector2d& p_map, double radius_m) {
  return WithReader([&](SqliteDatabase& database) -> absl::StatusOr<std::vector<CoverageRecord>> {
    absl::Status status = FindMap(database, map_name).status();
    if (!status.ok()) return status;
    return FindMapCoverage(database, map_name, p_map, radius_m);
  });
}

absl::StatusOr<std::vector<CoverageRecord>> SqliteCatalogue::FindCoverage(
    absl::string_view prefix, const GeodeticPosition& position, double radius_m, int limit) {
  absl::StatusOr<std::vector<CoverageRecord>> records = WithReader([&](SqliteDatabase& database) {
    return FindEarthCoverage(database, prefix, position, radius_m);
  });
  if (!records.ok()) return records;
  KeepNearest(limit, &*records);
  return records;
}

}  // namespace dcloc::server
