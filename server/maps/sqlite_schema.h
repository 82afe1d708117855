#pragma once

#include "server/maps/catalogue.h"
#include "server/maps/sqlite.h"

/// The catalogue's tables, and how their rows are read and written.
namespace dcloc::server {

inline constexpr std::int64_t kSchemaVersion = 1;

/// Makes the tables `map` and `map_version`, and the views `map_row` and `map_version_row` with the
/// columns that `ReadMap` and `ReadVersion` take. Sets the schema's version.
extern const char* const kCreateSchema;

/// Inserts what `BindVersion` binds.
extern const char* const kInsertVersion;

/// A whole row of `map_row`.
MapRecord ReadMap(SqliteStatement& row);

/// A whole row of `map_version_row`.
MapVersionRecord ReadVersion(SqliteStatement& row);

void BindVersion(const MapVersionRecord& record, SqliteStatement* insert);

}  // namespace dcloc::server
