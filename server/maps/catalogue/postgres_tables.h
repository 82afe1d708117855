#pragma once

#include "absl/status/status.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/postgres/postgres_connection.h"

/// The catalogue's tables in PostgreSQL, and how their rows are read and written.
namespace dcloc::server {

/// Makes the tables, or brings those of an earlier program up to date (`Migrate`). The tables of
/// changes (PostgresWatch) are there already. FailedPrecondition when PostGIS is not installed in
/// the database and this user may not do that.
absl::Status PrepareTables(PostgresConnection& connection);

/// Inserts what `BindVersion` binds.
extern const char* const kInsertPostgresVersion;

/// A whole row of `map_row`.
MapRecord ReadMap(PostgresRows& row);

/// A whole row of `map_version_row`.
MapVersionRecord ReadVersion(PostgresRows& row);

void BindVersion(const MapVersionRecord& record, PostgresValues* insert);

}  // namespace dcloc::server
