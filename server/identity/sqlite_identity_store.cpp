#include "server/identity/sqlite_identity_store.h"

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/identity/identity_rules.h"
#include "server/identity/token.h"

namespace dcloc::server {
namespace {

constexpr char kCreateSchema[] = R"(
CREATE TABLE IF NOT EXISTS identity (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  token_sha256 TEXT UNIQUE,
  common_name TEXT,
  name TEXT NOT NULL,
  tenant TEXT NOT NULL,
  role TEXT NOT NULL,
  create_time_ns INTEGER NOT NULL,
  expire_time_ns INTEGER,
  revoke_time_ns INTEGER
) STRICT;
CREATE UNIQUE INDEX IF NOT EXISTS identity_common_name ON identity(common_name)
  WHERE revoke_time_ns IS NULL;
)";

constexpr char kColumns[] =
    "SELECT id, token_sha256 IS NULL, name, tenant, role, create_time_ns, expire_time_ns,"
    " revoke_time_ns FROM identity ";

std::int64_t Nanoseconds(SystemTime time) { return time.time_since_epoch().count(); }

absl::StatusOr<IdentityRecord> Read(SqliteStatement& row) {
  return ReadIdentity(row, [](SqliteStatement& proof) { return proof.NextInteger() != 0; });
}

}  // namespace

SqliteIdentityStore::SqliteIdentityStore(SqliteDatabase database)
    : database_(std::move(database)) {}

absl::StatusOr<std::unique_ptr<SqliteIdentityStore>> SqliteIdentityStore::Open(
    const std::filesystem::path& path) {
  absl::StatusOr<SqliteDatabase> database = SqliteDatabase::Open(path);
  if (!database.ok()) return database.status();
  absl::Status status = database->Run("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;");
  status.Update(status.ok() ? database->Run(kCreateSchema) : status);
  if (!status.ok()) return status;
  return std::unique_ptr<SqliteIdentityStore>(new SqliteIdentityStore(*std::move(database)));
}

absl::StatusOr<std::string> SqliteIdentityStore::Create(Proof proof, const Principal& principal,
                                                        std::optional<SystemTime> expire_time) {
  absl::Status status = CheckPrincipal(principal);
  if (!status.ok()) return status;
  std::string token;
  if (proof == Proof::kToken) {
    absl::StatusOr<std::string> made = NewToken();
    if (!made.ok()) return made.status();
    token = *std::move(made);
  }
  const std::lock_guard lock(mutex_);
  SqliteStatement insert(database_,
                         "INSERT INTO identity (token_sha256, common_name, name, tenant, role,"
                         " create_time_ns, expire_time_ns) VALUES (?,?,?,?,?,?,?)");
  if (proof == Proof::kToken) {
    insert.Bind(HashOfToken(token)).BindNull();
  } else {
    insert.BindNull().Bind(principal.name);
  }
  insert.Bind(principal.name).Bind(principal.tenant).Bind(NameOf(principal.role));
  insert.Bind(Nanoseconds(std::chrono::system_clock::now()));
  expire_time ? insert.Bind(Nanoseconds(*expire_time)) : insert.BindNull();
  status = insert.Run();
  if (absl::IsAlreadyExists(status)) return CertificateNameTaken(principal.name);
  if (!status.ok()) return status;
  return token;
}

absl::StatusOr<std::vector<IdentityRecord>> SqliteIdentityStore::List(std::int64_t after,
                                                                      int limit) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_,
                        absl::StrCat(kColumns, "WHERE id > ? ORDER BY id LIMIT ?").c_str());
  query.Bind(after).Bind(std::int64_t{limit});
  std::vector<IdentityRecord> records;
  while (true) {
    const absl::StatusOr<bool> row = query.Step();
    if (!row.ok()) return row.status();
    if (!*row) return records;
    absl::StatusOr<IdentityRecord> record = Read(query);
    if (!record.ok()) return record.status();
    records.push_back(*std::move(record));
  }
}

absl::Status SqliteIdentityStore::Revoke(std::int64_t id) {
  const std::lock_guard lock(mutex_);
  SqliteStatement update(
      database_, "UPDATE identity SET revoke_time_ns = COALESCE(revoke_time_ns, ?) WHERE id = ?");
  absl::Status status = update.Bind(Nanoseconds(std::chrono::system_clock::now())).Bind(id).Run();
  if (status.ok() && database_.ChangedRowCount() == 0) return NoSuchIdentity(id);
  return status;
}

absl::StatusOr<Principal> SqliteIdentityStore::FindToken(absl::string_view token) {
  return Find("WHERE token_sha256 = ?", HashOfToken(token), ProofByToken());
}

absl::StatusOr<Principal> SqliteIdentityStore::FindCertificate(absl::string_view common_name) {
  return Find("WHERE common_name = ? ORDER BY id DESC LIMIT 1", common_name,
              ProofByCertificate(common_name));
}

absl::StatusOr<Principal> SqliteIdentityStore::Find(const char* sql, absl::string_view key,
                                                    absl::string_view what) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_, absl::StrCat(kColumns, sql).c_str());
  const absl::StatusOr<bool> row = query.Bind(key).Step();
  if (!row.ok()) return row.status();
  if (!*row) return ProofNotKnown(what);
  const absl::StatusOr<IdentityRecord> record = Read(query);
  if (!record.ok()) return record.status();
  return ValidPrincipal(*record, what, std::chrono::system_clock::now());
}

absl::StatusOr<bool> SqliteIdentityStore::HasAny() {
  const std::lock_guard lock(mutex_);
  if (has_any_) return true;
  SqliteStatement query(database_, "SELECT 1 FROM identity LIMIT 1");
  absl::StatusOr<bool> row = query.Step();
  if (row.ok()) has_any_ = *row;
  return row;
}

}  // namespace dcloc::server
