#include "server/maps/catalogue/postgres_hold_rows.h"

#include "absl/strings/str_cat.h"
#include "server/maps/catalogue/catalogue_errors.h"
#include "server/postgres/postgres_error.h"

namespace dcloc::server {
namespace {

PostgresValues ValuesOf(const VersionHoldKey& key) {
  PostgresValues values;
  values.Bind(key.map_name).Bind(key.version).Bind(key.holder);
  return values;
}

/// As for how long a lease lasts, see the view `live_holder`.
absl::Status BeginLease(PostgresConnection& connection, absl::string_view holder) {
  return connection
      .Query(
          "INSERT INTO holder VALUES ($1, clock_timestamp() + interval '15 s')"
          " ON CONFLICT (name) DO UPDATE SET lease_end = excluded.lease_end",
          PostgresValues().Bind(holder))
      .status();
}

absl::Status NotThere(PostgresConnection& connection, const VersionHoldKey& key) {
  absl::StatusOr<PostgresRows> rows =
      connection.Query("SELECT 1 FROM map WHERE name = $1", PostgresValues().Bind(key.map_name));
  if (!rows.ok()) return rows.status();
  return rows->Next() ? NoSuchVersion(key.map_name, key.version) : NoSuchMap(key.map_name);
}

}  // namespace

absl::StatusOr<bool> RenewLease(PostgresConnection& connection, absl::string_view holder) {
  const absl::StatusOr<PostgresRows> rows = connection.Query(
      "UPDATE holder SET lease_end = clock_timestamp() + interval '15 s' WHERE name = $1",
      PostgresValues().Bind(holder));
  if (!rows.ok()) return rows.status();
  if (rows->count() > 0) return true;
  if (absl::Status status = BeginLease(connection, holder); !status.ok()) return status;
  return false;
}

absl::Status DeleteHolder(PostgresConnection& connection, absl::string_view holder) {
  return connection.Query("DELETE FROM holder WHERE name = $1", PostgresValues().Bind(holder))
      .status();
}

absl::Status DeleteDeadHolders(PostgresConnection& connection) {
  return connection
      .Query(
          "DELETE FROM holder WHERE lease_end < clock_timestamp() - interval '1 min'"
          " AND name NOT IN (SELECT name FROM live_holder)")
      .status();
}

absl::Status InsertVersionHold(PostgresConnection& connection, const VersionHoldKey& key) {
  absl::Status status = BeginLease(connection, key.holder);
  if (!status.ok()) return status;
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "SELECT 1 FROM map_version WHERE map_name = $1 AND version = $2 FOR KEY SHARE NOWAIT",
      PostgresValues().Bind(key.map_name).Bind(key.version));
  // Only who deletes it locks it so.
  if (absl::IsUnavailable(rows.status()) && !IsAway(rows.status())) {
    return VersionBeingDeleted(key.map_name);
  }
  if (!rows.ok()) return rows.status();
  if (!rows->Next()) return NotThere(connection, key);
  return connection
      .Query(
          "INSERT INTO version_hold (map_name, version, holder) VALUES ($1, $2, $3)"
          " ON CONFLICT DO NOTHING",
          ValuesOf(key))
      .status();
}

absl::StatusOr<bool> InsertVersionHoldAgain(PostgresConnection& connection,
                                            const VersionHoldKey& key) {
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "WITH there AS (SELECT map_name, version FROM map_version"
      "   WHERE map_name = $1 AND version = $2 FOR KEY SHARE),"
      " held AS (INSERT INTO version_hold (map_name, version, holder)"
      "   SELECT map_name, version, $3 FROM there ON CONFLICT DO NOTHING)"
      " SELECT 1 FROM there",
      ValuesOf(key));
  if (!rows.ok()) return rows.status();
  return rows->Next();
}

absl::Status DeleteVersionHold(PostgresConnection& connection, const VersionHoldKey& key) {
  return connection
      .Query("DELETE FROM version_hold WHERE map_name = $1 AND version = $2 AND holder = $3",
             ValuesOf(key))
      .status();
}

absl::StatusOr<std::int64_t> NewestHeldVersion(PostgresConnection& connection,
                                               absl::string_view map_name, std::int64_t version) {
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "SELECT COALESCE(max(version), 0) FROM version_hold JOIN live_holder ON name = holder"
      " WHERE map_name = $1 AND ($2::bigint = 0 OR version = $2::bigint)",
      PostgresValues().Bind(map_name).Bind(version));
  if (!rows.ok()) return rows.status();
  rows->Next();
  return rows->NextInteger();
}

absl::StatusOr<std::int64_t> InsertFileHold(PostgresConnection& connection,
                                            absl::string_view sha256, absl::string_view holder,
                                            bool held_here) {
  absl::Status status = BeginLease(connection, holder);
  if (!status.ok()) return status;
  absl::StatusOr<PostgresRows> rows = connection.Query(
      "INSERT INTO file_hold VALUES ($1, $2, nextval('file_hold_token'))"
      " ON CONFLICT (sha256) DO UPDATE SET holder = excluded.holder, token = excluded.token"
      " WHERE file_hold.holder NOT IN (SELECT name FROM live_holder)"
      " OR (file_hold.holder = excluded.holder AND NOT $3::boolean)"
      " RETURNING token",
      PostgresValues().Bind(sha256).Bind(holder).Bind(held_here));
  if (!rows.ok()) return rows.status();
  if (rows->Next()) return rows->NextInteger();
  rows = connection.Query("SELECT holder FROM file_hold WHERE sha256 = $1",
                          PostgresValues().Bind(sha256));
  if (!rows.ok()) return rows.status();
  return FileHeld(sha256, rows->Next() ? rows->NextText() : "another server");
}

absl::Status DeleteFileHold(PostgresConnection& connection, std::int64_t token) {
  return connection.Query("DELETE FROM file_hold WHERE token = $1", PostgresValues().Bind(token))
      .status();
}

absl::Status CheckFileToken(PostgresConnection& connection, absl::string_view sha256,
                            std::int64_t token) {
  absl::StatusOr<PostgresRows> rows =
      connection.Query("SELECT 1 FROM file_hold WHERE sha256 = $1 AND token = $2 FOR SHARE",
                       PostgresValues().Bind(sha256).Bind(token));
  if (!rows.ok()) return rows.status();
  if (rows->Next()) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(
      "file ", sha256, " was held no more when its version was added; upload it again"));
}

}  // namespace dcloc::server
