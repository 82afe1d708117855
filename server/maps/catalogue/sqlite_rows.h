#pragma once

#include <string>
#include <utility>
#include <vector>

#include "server/base/sqlite.h"
#include "server/maps/catalogue/catalogue.h"

/// Single rows of the catalogue, looked up on either of its connections.
namespace dcloc::server {

/// Errors of Catalogue::GetMap.
absl::StatusOr<MapRecord> FindMap(SqliteDatabase& database, absl::string_view map_name);

/// NotFound: the map has no such version.
absl::StatusOr<MapVersionRecord> FindVersion(SqliteDatabase& database, absl::string_view map_name,
                                             std::int64_t version);

/// The version of a map that has this file, or 0.
absl::StatusOr<std::int64_t> VersionOfFile(SqliteDatabase& database, absl::string_view map_name,
                                           absl::string_view sha256);

/// Whether any version has this file.
absl::StatusOr<bool> HasVersionOfFile(SqliteDatabase& database, absl::string_view sha256);

/// Takes the map's next number, and creates the map if it is new.
absl::StatusOr<std::int64_t> TakeVersionNumber(SqliteDatabase& database,
                                               absl::string_view map_name);

/// All rows of a query, each as `read` takes it.
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

}  // namespace dcloc::server
