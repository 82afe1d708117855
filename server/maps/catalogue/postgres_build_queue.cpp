#include "server/maps/catalogue/postgres_build_queue.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/maps/catalogue/build_columns.h"
#include "server/postgres/postgres_migrations.h"

namespace dcloc::server {
namespace {

constexpr const char* kPostgresBuildSteps[] = {R"(
CREATE TABLE dcloc.map_build (
  number bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  build_id text COLLATE "C" NOT NULL UNIQUE,
  tenant text COLLATE "C" NOT NULL,
  map_name text COLLATE "C" NOT NULL,
  state bigint NOT NULL,
  create_time_ns bigint NOT NULL,
  input_sha256 text COLLATE "C" NOT NULL,
  report bytea NOT NULL,
  attempt_count bigint NOT NULL DEFAULT 0,
  cancelled boolean NOT NULL DEFAULT false,
  holder text COLLATE "C" NOT NULL DEFAULT '',
  lease_end timestamptz
);
CREATE INDEX map_build_tenant ON dcloc.map_build (tenant, number);
CREATE INDEX map_build_running ON dcloc.map_build (number) WHERE state = 0;
)"};
constexpr PostgresMigrations kBuildMigrations{.part = "builds", .steps = kPostgresBuildSteps};

/// Of a row that nobody builds. It is asked of the row itself, so that it holds again once the row
/// is locked.
constexpr char kIsFree[] =
    "state = 0 AND (holder = '' OR (lease_end < clock_timestamp()"
    " AND pg_postmaster_start_time() < clock_timestamp() - interval '15 s'))";

BuildRow ReadBuild(PostgresRows& row) {
  return NextBuild(row, [](PostgresRows& report) { return report.NextBytes(); });
}

PostgresValues ValuesOf(const BuildLease& lease) {
  PostgresValues values;
  values.Bind(lease.build_id).Bind(lease.holder).Bind(lease.attempt);
  return values;
}

absl::StatusOr<BuildRow> FindBuild(PostgresConnection& connection, absl::string_view tenant,
                                   absl::string_view build_id) {
  absl::StatusOr<PostgresRows> rows =
      connection.Query(SelectBuilds("WHERE tenant = $1 AND build_id = $2").c_str(),
                       PostgresValues().Bind(tenant).Bind(build_id));
  if (!rows.ok()) return rows.status();
  if (!rows->Next()) return NoSuchBuild(build_id);
  return ReadBuild(*rows);
}

/// Two that add at once are counted one after the other.
absl::Status CheckRunning(PostgresConnection& connection, absl::string_view tenant,
                          int max_running) {
  absl::StatusOr<PostgresRows> rows =
      connection.Query("SELECT pg_advisory_xact_lock(hashtext('dcloc builds ' || $1::text))",
                       PostgresValues().Bind(tenant));
  if (!rows.ok()) return rows.status();
  rows = connection.Query("SELECT count(*) FROM map_build WHERE tenant = $1 AND state = 0",
                          PostgresValues().Bind(tenant));
  if (!rows.ok()) return rows.status();
  rows->Next();
  return rows->NextInteger() >= max_running ? TooManyBuilds(max_running) : absl::OkStatus();
}

absl::Status Insert(PostgresConnection& connection, const BuildRow& row) {
  PostgresValues values;
  values.Bind(row.build_id).Bind(row.tenant).Bind(row.map_name).Bind(NumberOf(row.state));
  values.Bind(std::int64_t{row.create_time.time_since_epoch().count()});
  values.Bind(row.input_sha256).BindBytes(row.report);
  return connection
      .Query(
          "INSERT INTO map_build (build_id, tenant, map_name, state, create_time_ns, input_sha256,"
          " report) VALUES ($1, $2, $3, $4, $5, $6, $7)",
          values)
      .status();
}

absl::Status ForgetOldest(PostgresConnection& connection, absl::string_view tenant) {
  return connection
      .Query(
          "DELETE FROM map_build WHERE number IN (SELECT number FROM map_build"
          " WHERE tenant = $1 AND state <> 0 ORDER BY number DESC OFFSET $2)",
          PostgresValues().Bind(tenant).Bind(std::int64_t{BuildQueue::kMaxEnded}))
      .status();
}

/// Those whose builder died before it was told.
absl::Status EndCancelled(PostgresConnection& connection) {
  return connection
      .Query(absl::StrCat("UPDATE map_build SET state = $1 WHERE cancelled AND ", kIsFree).c_str(),
             PostgresValues().Bind(NumberOf(BuildState::kCancelled)))
      .status();
}

absl::StatusOr<bool> AnyIsFree(PostgresConnection& connection) {
  absl::StatusOr<PostgresRows> rows =
      connection.Query(absl::StrCat("SELECT 1 FROM map_build WHERE ", kIsFree, " LIMIT 1").c_str());
  if (!rows.ok()) return rows.status();
  return rows->Next();
}

}  // namespace

absl::StatusOr<std::unique_ptr<PostgresBuildQueue>> PostgresBuildQueue::Open(
    std::shared_ptr<PostgresDatabase> database) {
  absl::Status status = database->pool.WithConnection(
      [](PostgresConnection& connection) { return Migrate(connection, kBuildMigrations); });
  if (!status.ok()) return status;
  return std::unique_ptr<PostgresBuildQueue>(new PostgresBuildQueue(std::move(database)));
}

absl::Status PostgresBuildQueue::Add(const BuildRow& row, int max_running) {
  return database_->pool.InTransaction([&](PostgresConnection& connection) {
    absl::Status status = CheckRunning(connection, row.tenant, max_running);
    if (status.ok()) status = Insert(connection, row);
    return status.ok() ? ForgetOldest(connection, row.tenant) : status;
  });
}

absl::StatusOr<BuildRow> PostgresBuildQueue::Get(absl::string_view tenant,
                                                 absl::string_view build_id) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) { return FindBuild(connection, tenant, build_id); });
}

absl::StatusOr<std::vector<BuildRow>> PostgresBuildQueue::List(absl::string_view tenant) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::vector<BuildRow>> {
        absl::StatusOr<PostgresRows> rows =
            connection.Query(SelectBuilds("WHERE tenant = $1 ORDER BY number DESC").c_str(),
                             PostgresValues().Bind(tenant));
        if (!rows.ok()) return rows.status();
        std::vector<BuildRow> builds;
        while (rows->Next()) builds.push_back(ReadBuild(*rows));
        return builds;
      });
}

absl::StatusOr<std::vector<std::string>> PostgresBuildQueue::ListRunning() {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::vector<std::string>> {
        absl::StatusOr<PostgresRows> rows =
            connection.Query("SELECT build_id FROM map_build WHERE state = 0");
        if (!rows.ok()) return rows.status();
        std::vector<std::string> ids;
        while (rows->Next()) ids.push_back(rows->NextText());
        return ids;
      });
}

absl::StatusOr<BuildRow> PostgresBuildQueue::Cancel(absl::string_view tenant,
                                                    absl::string_view build_id) {
  absl::Status status = database_->pool.InTransaction([&](PostgresConnection& connection) {
    return connection
        .Query(
            "UPDATE map_build SET cancelled = true,"
            " state = CASE WHEN holder = '' THEN $3::bigint ELSE state END"
            " WHERE tenant = $1 AND build_id = $2 AND state = 0",
            PostgresValues().Bind(tenant).Bind(build_id).Bind(NumberOf(BuildState::kCancelled)))
        .status();
  });
  if (!status.ok()) return status;
  return Get(tenant, build_id);
}

absl::StatusOr<std::optional<BuildRow>> PostgresBuildQueue::Take(absl::string_view holder) {
  // Most often there is none: that needs no transaction.
  const absl::StatusOr<bool> any = database_->pool.WithConnection(&AnyIsFree);
  if (!any.ok()) return any.status();
  if (!*any) return std::nullopt;
  std::optional<BuildRow> taken;
  absl::Status status = database_->pool.InTransaction([&](PostgresConnection& connection) {
    absl::Status ended = EndCancelled(connection);
    if (!ended.ok()) return ended;
    absl::StatusOr<PostgresRows> rows = connection.Query(
        absl::StrCat("UPDATE map_build SET holder = $1, attempt_count = attempt_count + 1,"
                     " lease_end = clock_timestamp() + interval '15 s' WHERE number ="
                     " (SELECT number FROM map_build WHERE ",
                     kIsFree, " ORDER BY number LIMIT 1 FOR UPDATE SKIP LOCKED) RETURNING ",
                     kBuildColumns)
            .c_str(),
        PostgresValues().Bind(holder));
    if (rows.ok() && rows->Next()) taken = ReadBuild(*rows);
    return rows.status();
  });
  if (!status.ok()) return status;
  return taken;
}

absl::StatusOr<LeaseState> PostgresBuildQueue::Renew(const BuildLease& lease,
                                                     absl::string_view report) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<LeaseState> {
        absl::StatusOr<PostgresRows> rows = connection.Query(
            "UPDATE map_build SET lease_end = clock_timestamp() + interval '15 s', report = $4"
            " WHERE build_id = $1 AND holder = $2 AND attempt_count = $3 AND state = 0"
            " RETURNING cancelled",
            ValuesOf(lease).BindBytes(report));
        if (!rows.ok()) return rows.status();
        if (!rows->Next()) return LeaseState::kLost;
        return rows->NextBool() ? LeaseState::kCancelled : LeaseState::kHeld;
      });
}

absl::StatusOr<bool> PostgresBuildQueue::End(const BuildLease& lease, BuildState state,
                                             absl::string_view report) {
  bool ended = false;
  absl::Status status = database_->pool.InTransaction([&](PostgresConnection& connection) {
    const absl::StatusOr<PostgresRows> rows = connection.Query(
        "UPDATE map_build SET state = $4, report = $5"
        " WHERE build_id = $1 AND holder = $2 AND attempt_count = $3 AND state = 0",
        ValuesOf(lease).Bind(NumberOf(state)).BindBytes(report));
    ended = rows.ok() && rows->count() > 0;
    return rows.status();
  });
  if (!status.ok()) return status;
  return ended;
}

absl::Status PostgresBuildQueue::GiveBack(const BuildLease& lease) {
  return database_->pool.InTransaction([&](PostgresConnection& connection) {
    return connection
        .Query(
            "UPDATE map_build SET holder = '', attempt_count = attempt_count - 1"
            " WHERE build_id = $1 AND holder = $2 AND attempt_count = $3 AND state = 0",
            ValuesOf(lease))
        .status();
  });
}

}  // namespace dcloc::server
