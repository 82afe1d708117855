#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/maps/catalogue/catalogue.h"
#include "server/postgres/postgres_connection.h"

/// Rows of maps and versions, looked up and changed. Errors beyond those named are the database's.
namespace dcloc::server {

/// What becomes of a row that is looked up in a transaction.
enum class RowLock {
  kNone,
  kChange,  ///< it is changed: other changes wait until the transaction ends
};

/// NotFound: no such map.
absl::StatusOr<MapRecord> FindMap(PostgresConnection& connection, absl::string_view map_name,
                                  RowLock lock = RowLock::kNone);

/// Errors of Catalogue::GetVersion.
absl::StatusOr<MapVersionRecord> FindVersion(PostgresConnection& connection,
                                             absl::string_view map_name, std::int64_t version);

/// The version of a map that has this file, or 0.
absl::StatusOr<std::int64_t> VersionOfFile(PostgresConnection& connection,
                                           absl::string_view map_name, absl::string_view sha256);

/// Takes the map's next number, and creates the map if it is new. Other changes of the map wait.
absl::StatusOr<std::int64_t> TakeVersionNumber(PostgresConnection& connection,
                                               absl::string_view map_name);

absl::Status InsertVersion(PostgresConnection& connection, const MapVersionRecord& record,
                           const std::vector<CoverageBox>& coverage);

/// Locks a map's version (0: all of them) for deletion; gives their files. Who holds a version
/// waits for nothing (InsertVersionHold).
absl::StatusOr<std::vector<std::string>> LockFilesOf(PostgresConnection& connection,
                                                     absl::string_view map_name,
                                                     std::int64_t version);

/// Until the transaction ends, no other one adds or deletes versions with one of these files: of
/// two that delete the last two, one must see that it deletes the last.
absl::Status LockFiles(PostgresConnection& connection, std::vector<std::string> files);

/// Notes those of the files that no version has any more.
absl::Status NoteLooseFiles(PostgresConnection& connection, const std::vector<std::string>& files);

/// The first column of each row.
std::vector<std::string> TextsOf(PostgresRows rows);

/// All rows, each as `read` takes it.
template <typename Record>
std::vector<Record> ReadAll(PostgresRows& rows, Record (*read)(PostgresRows&)) {
  std::vector<Record> records;
  while (rows.Next()) records.push_back(read(rows));
  return records;
}

}  // namespace dcloc::server
