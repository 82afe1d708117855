#pragma once

#include "server/base/sqlite.h"
#include "server/maps/catalogue/catalogue.h"

/// The catalogue's tables, and how their rows are read and written.
namespace dcloc::server {

inline constexpr std::int64_t kSchemaVersion = 3;

/// Makes the schema in an empty database, or brings that of an earlier program to the present one.
/// FailedPrecondition when a newer program wrote it, or when it is no catalogue; then nothing is
/// changed.
///
/// The tables are `map`, `map_version`, `loose_file` and those of the coverage. The views `map_row`
/// and `map_version_row` have the columns that `ReadMap` and `ReadVersion` take. Versions of a
/// catalogue of version 1 have no coverage yet, as their files are needed for it.
absl::Status PrepareSchema(SqliteDatabase& database);

/// As `PrepareSchema`, but changes nothing: OK when it would succeed.
absl::Status CheckSchema(SqliteDatabase& database);

/// OK when the schema is of `kSchemaVersion`. FailedPrecondition otherwise.
absl::Status CheckSchemaIsPresent(SqliteDatabase& database);

/// Inserts what `BindVersion` binds.
extern const char* const kInsertVersion;

/// A whole row of `map_row`.
MapRecord ReadMap(SqliteStatement& row);

/// A whole row of `map_version_row`.
MapVersionRecord ReadVersion(SqliteStatement& row);

void BindVersion(const MapVersionRecord& record, SqliteStatement* insert);

}  // namespace dcloc::server
