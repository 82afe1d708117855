#pragma once

#include "server/base/sqlite.h"
#include "server/maps/catalogue/catalogue.h"

/// The catalogue's tables, and how their rows are read and written.
namespace dcloc::server {

inline constexpr std::int64_t kSchemaVersion = 2;

/// Makes the tables `map` and `map_version`, and the views `map_row` and `map_version_row` with the
/// columns that `ReadMap` and `ReadVersion` take. Sets the schema's version.
extern const char* const kCreateSchema;

/// Brings a catalogue of version 1 to the present one, but for the coverage of the versions that
/// are there already, for which their files are needed.
extern const char* const kMigrateFrom1;

/// Inserts what `BindVersion` binds.
extern const char* const kInsertVersion;

/// A whole row of `map_row`.
MapRecord ReadMap(SqliteStatement& row);

/// A whole row of `map_version_row`.
MapVersionRecord ReadVersion(SqliteStatement& row);

void BindVersion(const MapVersionRecord& record, SqliteStatement* insert);

}  // namespace dcloc::server
