#include "server/passes/sqlite_pass_rows.h"

#include <utility>

#include "server/base/sqlite_steps.h"
#include "server/passes/pass_columns.h"

namespace dcloc::server {
namespace {

constexpr const char* kSqlitePassSteps[] = {R"(
CREATE TABLE pass_consent (
  tenant TEXT NOT NULL,
  subject INTEGER NOT NULL,
  name TEXT NOT NULL,
  PRIMARY KEY (tenant, subject, name)
) STRICT, WITHOUT ROWID;

CREATE TABLE pass (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  pass_id TEXT NOT NULL UNIQUE,
  tenant TEXT NOT NULL,
  map_name TEXT NOT NULL,
  map_version INTEGER NOT NULL,
  vehicle TEXT NOT NULL,
  identity TEXT NOT NULL,
  scan_count INTEGER NOT NULL,
  size_bytes INTEGER NOT NULL,
  first_stamp_ns INTEGER NOT NULL,
  last_stamp_ns INTEGER NOT NULL,
  sha256 TEXT NOT NULL,
  create_time_ns INTEGER NOT NULL,
  expire_time_ns INTEGER NOT NULL
) STRICT;
CREATE INDEX pass_map ON pass (tenant, map_name, number);
CREATE INDEX pass_vehicle ON pass (tenant, vehicle, create_time_ns);
CREATE INDEX pass_expire ON pass (expire_time_ns);
)"};

template <typename Read>
auto ReadRows(SqliteStatement& query, const Read& read)
    -> absl::StatusOr<std::vector<decltype(read(query))>> {
  std::vector<decltype(read(query))> rows;
  while (true) {
    const absl::StatusOr<bool> row = query.Step();
    if (!row.ok()) return row.status();
    if (!*row) return rows;
    rows.push_back(read(query));
  }
}

std::string ReadSqliteText(SqliteStatement& row) { return row.NextText(); }

absl::StatusOr<std::int64_t> ReadNumber(SqliteStatement& query) {
  const absl::StatusOr<bool> row = query.Step();
  if (!row.ok()) return row.status();
  return query.NextInteger();
}

absl::StatusOr<bool> Consent(SqliteDatabase& database, absl::string_view tenant,
                             absl::string_view map_name, absl::string_view identity_name) {
  SqliteStatement query(database,
                        "SELECT COUNT(*) FROM pass_consent WHERE tenant = ?1 AND"
                        " ((subject = 0 AND name = ?2) OR (subject = 1 AND name = ?3))");
  const auto count = ReadNumber(query.Bind(tenant).Bind(map_name).Bind(identity_name));
  if (!count.ok()) return count.status();
  return *count == 2;
}

absl::Status CheckRoom(SqliteDatabase& database, const PassRow& row, const PassQuota& quota) {
  SqliteStatement tenant(database,
                         "SELECT COALESCE(SUM(size_bytes), 0) FROM pass WHERE tenant = ?");
  const auto tenant_bytes = ReadNumber(tenant.Bind(row.tenant));
  if (!tenant_bytes.ok()) return tenant_bytes.status();
  SqliteStatement vehicle(database,
                          "SELECT COALESCE(SUM(size_bytes), 0) FROM pass WHERE tenant = ?"
                          " AND vehicle = ? AND create_time_ns > ?");
  const auto vehicle_bytes = ReadNumber(
      vehicle.Bind(row.tenant).Bind(row.vehicle).Bind(NanosecondsOf(row.create_time) - kDay_ns));
  if (!vehicle_bytes.ok()) return vehicle_bytes.status();
  return CheckQuota(row.size_bytes, *tenant_bytes, *vehicle_bytes, quota);
}

absl::Status Insert(SqliteDatabase& database, const PassRow& row) {
  SqliteStatement insert(
      database,
      "INSERT INTO pass (pass_id, tenant, map_name, map_version, vehicle, identity, scan_count,"
      " size_bytes, first_stamp_ns, last_stamp_ns, sha256, create_time_ns, expire_time_ns)"
      " VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)");
  BindPass(row, insert);
  return insert.Run();
}

}  // namespace

absl::StatusOr<std::unique_ptr<SqlitePassRows>> SqlitePassRows::Open(
    const std::filesystem::path& path) {
  absl::StatusOr<SqliteDatabase> database = SqliteDatabase::Open(path);
  if (!database.ok()) return database.status();
  if (absl::Status status = TakeSteps(*database, "passes", kSqlitePassSteps); !status.ok())
    return status;
  return std::unique_ptr<SqlitePassRows>(new SqlitePassRows(*std::move(database)));
}

template <typename Change>
absl::Status SqlitePassRows::InTransaction(const Change& change) {
  const std::lock_guard lock(mutex_);
  SqliteTransaction transaction(database_);
  absl::Status status = transaction.status();
  if (status.ok()) status = change();
  return status.ok() ? transaction.Commit() : status;
}

absl::Status SqlitePassRows::GiveConsent(absl::string_view tenant, const ConsentRow& consent) {
  const std::lock_guard lock(mutex_);
  SqliteStatement insert(database_, "INSERT OR IGNORE INTO pass_consent VALUES (?,?,?)");
  return insert.Bind(tenant).Bind(NumberOf(consent.subject)).Bind(consent.name).Run();
}

absl::StatusOr<std::vector<std::string>> SqlitePassRows::WithdrawConsent(
    absl::string_view tenant, const ConsentRow& consent, absl::string_view pseudonym) {
  absl::StatusOr<std::vector<std::string>> ids;
  absl::Status status = InTransaction([&]() -> absl::Status {
    SqliteStatement erase(database_,
                          "DELETE FROM pass_consent WHERE tenant = ? AND subject = ? AND name = ?");
    absl::Status done = erase.Bind(tenant).Bind(NumberOf(consent.subject)).Bind(consent.name).Run();
    if (!done.ok()) return done;
    const bool of_map = consent.subject == ConsentSubject::kMap;
    SqliteStatement passes(
        database_, of_map ? "DELETE FROM pass WHERE tenant = ? AND map_name = ? RETURNING pass_id"
                          : "DELETE FROM pass WHERE tenant = ? AND identity = ? RETURNING pass_id");
    passes.Bind(tenant).Bind(of_map ? absl::string_view(consent.name) : pseudonym);
    ids = ReadRows(passes, ReadSqliteText);
    return ids.status();
  });
  if (!status.ok()) return status;
  return ids;
}

absl::StatusOr<bool> SqlitePassRows::MayKeep(absl::string_view tenant, absl::string_view map_name,
                                             absl::string_view identity_name) {
  const std::lock_guard lock(mutex_);
  return Consent(database_, tenant, map_name, identity_name);
}

absl::StatusOr<std::vector<ConsentRow>> SqlitePassRows::ListConsents(absl::string_view tenant,
                                                                     std::int64_t offset,
                                                                     int limit) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_,
                        "SELECT subject, name FROM pass_consent WHERE tenant = ?"
                        " ORDER BY subject, name LIMIT ? OFFSET ?");
  query.Bind(tenant).Bind(std::int64_t{limit}).Bind(offset);
  return ReadRows(query, NextConsent<SqliteStatement>);
}

absl::Status SqlitePassRows::Add(const PassRow& row, absl::string_view identity_name,
                                 const PassQuota& quota) {
  return InTransaction([&]() -> absl::Status {
    const absl::StatusOr<bool> may = Consent(database_, row.tenant, row.map_name, identity_name);
    if (!may.ok()) return may.status();
    if (!*may) return NoConsent();
    absl::Status status = CheckRoom(database_, row, quota);
    return status.ok() ? Insert(database_, row) : status;
  });
}

absl::StatusOr<std::vector<PassRow>> SqlitePassRows::List(absl::string_view tenant,
                                                          absl::string_view map_name,
                                                          std::int64_t below, int limit) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_,
                        "SELECT * FROM pass WHERE tenant = ? AND map_name = ? AND number < ?"
                        " ORDER BY number DESC LIMIT ?");
  query.Bind(tenant).Bind(map_name).Bind(below).Bind(std::int64_t{limit});
  return ReadRows(query, NextPass<SqliteStatement>);
}

absl::StatusOr<std::vector<std::string>> SqlitePassRows::RemoveExpired(SystemTime now) {
  const std::lock_guard lock(mutex_);
  SqliteStatement erase(database_, "DELETE FROM pass WHERE expire_time_ns <= ? RETURNING pass_id");
  erase.Bind(NanosecondsOf(now));
  return ReadRows(erase, ReadSqliteText);
}

absl::StatusOr<std::vector<std::string>> SqlitePassRows::ListIds() {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_, "SELECT pass_id FROM pass");
  return ReadRows(query, ReadSqliteText);
}

absl::StatusOr<std::int64_t> SqlitePassRows::TotalBytes() {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_, "SELECT COALESCE(SUM(size_bytes), 0) FROM pass");
  return ReadNumber(query);
}

}  // namespace dcloc::server
