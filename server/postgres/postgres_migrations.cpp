#include "server/postgres/postgres_migrations.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/postgres/advisory_lock.h"

namespace dcloc::server {
namespace {

/// For all steps together; an index over a million rows takes its time.
constexpr std::chrono::minutes kTimeout(5);

/// The lock is taken before the schema is looked for, as two that make one at once would disturb
/// each other.
std::string BeginSql() {
  return absl::StrCat(R"(
BEGIN;
SET LOCAL statement_timeout = '5min'; SET LOCAL lock_timeout = '1min';
SELECT pg_advisory_xact_lock()",
                      kAdvisoryLock, R"();
DO $$ BEGIN
  IF to_regnamespace('dcloc') IS NULL THEN CREATE SCHEMA dcloc; END IF;
  IF to_regclass('dcloc.schema_version') IS NULL THEN
    CREATE TABLE dcloc.schema_version (part text PRIMARY KEY, version bigint NOT NULL);
  END IF;
END $$;
)");
}

absl::StatusOr<std::int64_t> VersionOf(PostgresConnection& connection, const char* part) {
  absl::StatusOr<PostgresRows> rows =
      connection.Query("SELECT to_regclass('dcloc.schema_version') IS NOT NULL", PostgresValues());
  if (!rows.ok()) return rows.status();
  if (rows->Next(); !rows->NextBool()) return 0;
  rows = connection.Query("SELECT version FROM dcloc.schema_version WHERE part = $1",
                          PostgresValues().Bind(absl::string_view(part)));
  if (!rows.ok()) return rows.status();
  return rows->Next() ? rows->NextInteger() : 0;
}

absl::Status CheckVersion(const PostgresMigrations& migrations, std::int64_t version) {
  if (version <= static_cast<std::int64_t>(migrations.steps.size())) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrFormat(
      "database: its schema of %s has version %d, from a newer program; this program knows %d",
      migrations.part, version, migrations.steps.size()));
}

/// In the transaction.
absl::Status TakeSteps(PostgresConnection& connection, const PostgresMigrations& migrations) {
  // Another program may have been first.
  const absl::StatusOr<std::int64_t> version = VersionOf(connection, migrations.part);
  if (!version.ok()) return version.status();
  if (absl::Status status = CheckVersion(migrations, *version); !status.ok()) return status;
  const std::size_t step_count = migrations.steps.size();
  for (auto step = static_cast<std::size_t>(*version); step < step_count; ++step) {
    const absl::Status status = connection.RunAll(migrations.steps[step], kTimeout).status();
    if (!status.ok()) {
      return WithPrefix(absl::StrCat("step ", step + 1, " of ", migrations.part, ": "), status);
    }
  }
  return connection
      .Query(
          "INSERT INTO dcloc.schema_version VALUES ($1, $2)"
          " ON CONFLICT (part) DO UPDATE SET version = excluded.version",
          PostgresValues()
              .Bind(absl::string_view(migrations.part))
              .Bind(static_cast<std::int64_t>(step_count)))
      .status();
}

}  // namespace

absl::Status Migrate(PostgresConnection& connection, const PostgresMigrations& migrations) {
  const absl::StatusOr<std::int64_t> version = VersionOf(connection, migrations.part);
  if (!version.ok()) return version.status();
  if (*version == static_cast<std::int64_t>(migrations.steps.size())) return absl::OkStatus();
  absl::Status status = CheckVersion(migrations, *version);
  if (!status.ok()) return status;
  status = connection.RunAll(BeginSql(), kTimeout).status();
  if (status.ok()) status = TakeSteps(connection, migrations);
  if (status.ok()) return connection.Query("COMMIT").status();
  connection.Query("ROLLBACK").status().IgnoreError();
  return status;
}

}  // namespace dcloc::server
