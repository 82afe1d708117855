#include "server/passes/postgres_pass_rows.h"

#include <utility>

#include "server/passes/pass_columns.h"
#include "server/postgres/postgres_migrations.h"

namespace dcloc::server {
namespace {

constexpr const char* kPostgresPassSteps[] = {R"(
CREATE TABLE dcloc.pass_consent (
  tenant text COLLATE "C" NOT NULL,
  subject bigint NOT NULL,
  name text COLLATE "C" NOT NULL,
  PRIMARY KEY (tenant, subject, name)
);

CREATE TABLE dcloc.pass (
  number bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  pass_id text COLLATE "C" NOT NULL UNIQUE,
  tenant text COLLATE "C" NOT NULL,
  map_name text COLLATE "C" NOT NULL,
  map_version bigint NOT NULL,
  vehicle text COLLATE "C" NOT NULL,
  identity text COLLATE "C" NOT NULL,
  scan_count bigint NOT NULL,
  size_bytes bigint NOT NULL,
  first_stamp_ns bigint NOT NULL,
  last_stamp_ns bigint NOT NULL,
  sha256 text COLLATE "C" NOT NULL,
  create_time_ns bigint NOT NULL,
  expire_time_ns bigint NOT NULL
);
CREATE INDEX pass_map ON dcloc.pass (tenant, map_name, number);
CREATE INDEX pass_vehicle ON dcloc.pass (tenant, vehicle, create_time_ns);
CREATE INDEX pass_expire ON dcloc.pass (expire_time_ns);
)"};
constexpr PostgresMigrations kPassMigrations{.part = "passes", .steps = kPostgresPassSteps};

template <typename Read>
auto ReadRows(absl::StatusOr<PostgresRows> rows, const Read& read)
    -> absl::StatusOr<std::vector<decltype(read(*rows))>> {
  if (!rows.ok()) return rows.status();
  std::vector<decltype(read(*rows))> all;
  while (rows->Next()) all.push_back(read(*rows));
  return all;
}

std::string ReadPostgresText(PostgresRows& row) { return row.NextText(); }

absl::StatusOr<std::int64_t> ReadNumber(PostgresConnection& connection, const char* sql,
                                        const PostgresValues& values) {
  absl::StatusOr<PostgresRows> rows = connection.Query(sql, values);
  if (!rows.ok()) return rows.status();
  rows->Next();
  return rows->NextInteger();
}

absl::StatusOr<bool> Consent(PostgresConnection& connection, absl::string_view tenant,
                             absl::string_view map_name, absl::string_view identity_name) {
  const auto count = ReadNumber(connection,
                                "SELECT count(*) FROM pass_consent WHERE tenant = $1 AND"
                                " ((subject = 0 AND name = $2) OR (subject = 1 AND name = $3))",
                                PostgresValues().Bind(tenant).Bind(map_name).Bind(identity_name));
  if (!count.ok()) return count.status();
  return *count == 2;
}

/// Those that keep passes of a tenant, or take its consents, at once do it one after the other.
absl::Status Lock(PostgresConnection& connection, absl::string_view tenant) {
  return connection
      .Query("SELECT pg_advisory_xact_lock(hashtext('dcloc passes ' || $1::text))",
             PostgresValues().Bind(tenant))
      .status();
}

absl::Status CheckRoom(PostgresConnection& connection, const PassRow& row, const PassQuota& quota) {
  const auto tenant_bytes = ReadNumber(
      connection, "SELECT COALESCE(sum(size_bytes), 0)::bigint FROM pass WHERE tenant = $1",
      PostgresValues().Bind(row.tenant));
  if (!tenant_bytes.ok()) return tenant_bytes.status();
  const auto vehicle_bytes =
      ReadNumber(connection,
                 "SELECT COALESCE(sum(size_bytes), 0)::bigint FROM pass WHERE tenant = $1"
                 " AND vehicle = $2 AND create_time_ns > $3",
                 PostgresValues()
                     .Bind(row.tenant)
                     .Bind(row.vehicle)
                     .Bind(NanosecondsOf(row.create_time) - kDay_ns));
  if (!vehicle_bytes.ok()) return vehicle_bytes.status();
  return CheckQuota(row.size_bytes, *tenant_bytes, *vehicle_bytes, quota);
}

absl::Status Insert(PostgresConnection& connection, const PassRow& row) {
  PostgresValues values;
  BindPass(row, values);
  return connection
      .Query(
          "INSERT INTO pass (pass_id, tenant, map_name, map_version, vehicle, identity,"
          " scan_count, size_bytes, first_stamp_ns, last_stamp_ns, sha256, create_time_ns,"
          " expire_time_ns) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)",
          values)
      .status();
}

}  // namespace

absl::StatusOr<std::unique_ptr<PostgresPassRows>> PostgresPassRows::Open(
    std::shared_ptr<PostgresDatabase> database) {
  absl::Status status = database->pool.WithConnection(
      [](PostgresConnection& connection) { return Migrate(connection, kPassMigrations); });
  if (!status.ok()) return status;
  return std::unique_ptr<PostgresPassRows>(new PostgresPassRows(std::move(database)));
}

absl::Status PostgresPassRows::GiveConsent(absl::string_view tenant, const ConsentRow& consent) {
  return database_->pool.InTransaction([&](PostgresConnection& connection) {
    return connection
        .Query("INSERT INTO pass_consent VALUES ($1, $2, $3) ON CONFLICT DO NOTHING",
               PostgresValues().Bind(tenant).Bind(NumberOf(consent.subject)).Bind(consent.name))
        .status();
  });
}

absl::StatusOr<std::vector<std::string>> PostgresPassRows::WithdrawConsent(
    absl::string_view tenant, const ConsentRow& consent, absl::string_view pseudonym) {
  absl::StatusOr<std::vector<std::string>> ids;
  absl::Status status = database_->pool.InTransaction([&](PostgresConnection& connection) {
    absl::Status done = Lock(connection, tenant);
    if (!done.ok()) return done;
    done =
        connection
            .Query("DELETE FROM pass_consent WHERE tenant = $1 AND subject = $2 AND name = $3",
                   PostgresValues().Bind(tenant).Bind(NumberOf(consent.subject)).Bind(consent.name))
            .status();
    if (!done.ok()) return done;
    const bool of_map = consent.subject == ConsentSubject::kMap;
    ids = ReadRows(
        connection.Query(
            of_map ? "DELETE FROM pass WHERE tenant = $1 AND map_name = $2 RETURNING pass_id"
                   : "DELETE FROM pass WHERE tenant = $1 AND identity = $2 RETURNING pass_id",
            PostgresValues().Bind(tenant).Bind(of_map ? absl::string_view(consent.name)
                                                      : pseudonym)),
        ReadPostgresText);
    return ids.status();
  });
  if (!status.ok()) return status;
  return ids;
}

absl::StatusOr<bool> PostgresPassRows::MayKeep(absl::string_view tenant, absl::string_view map_name,
                                               absl::string_view identity_name) {
  return database_->pool.WithConnection([&](PostgresConnection& connection) {
    return Consent(connection, tenant, map_name, identity_name);
  });
}

absl::StatusOr<std::vector<ConsentRow>> PostgresPassRows::ListConsents(absl::string_view tenant,
                                                                       std::int64_t offset,
                                                                       int limit) {
  return database_->pool.WithConnection([&](PostgresConnection& connection) {
    return ReadRows(
        connection.Query("SELECT subject, name FROM pass_consent WHERE tenant = $1"
                         " ORDER BY subject, name LIMIT $2 OFFSET $3",
                         PostgresValues().Bind(tenant).Bind(std::int64_t{limit}).Bind(offset)),
        NextConsent<PostgresRows>);
  });
}

absl::Status PostgresPassRows::Add(const PassRow& row, absl::string_view identity_name,
                                   const PassQuota& quota) {
  return database_->pool.InTransaction([&](PostgresConnection& connection) -> absl::Status {
    absl::Status status = Lock(connection, row.tenant);
    if (!status.ok()) return status;
    const absl::StatusOr<bool> may = Consent(connection, row.tenant, row.map_name, identity_name);
    if (!may.ok()) return may.status();
    if (!*may) return NoConsent();
    status = CheckRoom(connection, row, quota);
    return status.ok() ? Insert(connection, row) : status;
  });
}

absl::StatusOr<std::vector<PassRow>> PostgresPassRows::List(absl::string_view tenant,
                                                            absl::string_view map_name,
                                                            std::int64_t below, int limit) {
  return database_->pool.WithConnection([&](PostgresConnection& connection) {
    return ReadRows(
        connection.Query(
            "SELECT * FROM pass WHERE tenant = $1 AND map_name = $2 AND number < $3"
            " ORDER BY number DESC LIMIT $4",
            PostgresValues().Bind(tenant).Bind(map_name).Bind(below).Bind(std::int64_t{limit})),
        NextPass<PostgresRows>);
  });
}

absl::StatusOr<std::vector<std::string>> PostgresPassRows::RemoveExpired(SystemTime now) {
  return database_->pool.WithConnection([&](PostgresConnection& connection) {
    return ReadRows(
        connection.Query("DELETE FROM pass WHERE expire_time_ns <= $1 RETURNING pass_id",
                         PostgresValues().Bind(NanosecondsOf(now))),
        ReadPostgresText);
  });
}

absl::StatusOr<std::vector<std::string>> PostgresPassRows::ListIds() {
  return database_->pool.WithConnection([&](PostgresConnection& connection) {
    return ReadRows(connection.Query("SELECT pass_id FROM pass"), ReadPostgresText);
  });
}

absl::StatusOr<std::int64_t> PostgresPassRows::TotalBytes() {
  return database_->pool.WithConnection([&](PostgresConnection& connection) {
    return ReadNumber(connection, "SELECT COALESCE(sum(size_bytes), 0)::bigint FROM pass",
                      PostgresValues());
  });
}

}  // namespace dcloc::server
