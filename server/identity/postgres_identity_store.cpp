#include "server/identity/postgres_identity_store.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/check.h"
#include "server/identity/identity_rules.h"
#include "server/identity/token.h"
#include "server/postgres/postgres_migrations.h"

namespace dcloc::server {
namespace {

constexpr const char* kSteps[] = {R"(
CREATE TABLE dcloc.identity (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  token_sha256 text COLLATE "C" UNIQUE,
  common_name text COLLATE "C",
  name text COLLATE "C" NOT NULL,
  tenant text COLLATE "C" NOT NULL,
  role text COLLATE "C" NOT NULL,
  create_time_ns bigint NOT NULL,
  expire_time_ns bigint,
  revoke_time_ns bigint
);
CREATE UNIQUE INDEX identity_common_name ON dcloc.identity (common_name)
  WHERE revoke_time_ns IS NULL;
CREATE INDEX identity_last_common_name ON dcloc.identity (common_name, id);
CREATE CONSTRAINT TRIGGER identity_change AFTER INSERT OR UPDATE OR DELETE ON dcloc.identity
  DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION dcloc.note_change('identities');
)"};
constexpr PostgresMigrations kMigrations{.part = "identities", .steps = kSteps};

constexpr char kIdentityColumns[] =
    "SELECT id, token_sha256 IS NULL, name, tenant, role, create_time_ns, expire_time_ns,"
    " revoke_time_ns FROM identity ";

std::int64_t NanosecondsOf(SystemTime time) { return time.time_since_epoch().count(); }

std::int64_t NowNanoseconds() { return NanosecondsOf(std::chrono::system_clock::now()); }

absl::StatusOr<IdentityRecord> Read(PostgresRows& row) {
  return ReadIdentity(row, [](PostgresRows& proof) { return proof.NextBool(); });
}

/// `token` is empty for a certificate.
PostgresValues ValuesOf(const std::string& token, const Principal& principal,
                        std::optional<SystemTime> expire_time) {
  PostgresValues values;
  if (token.empty()) {
    values.BindNull().Bind(principal.name);
  } else {
    values.Bind(HashOfToken(token)).BindNull();
  }
  values.Bind(principal.name).Bind(principal.tenant).Bind(NameOf(principal.role));
  values.Bind(NowNanoseconds());
  expire_time ? values.Bind(NanosecondsOf(*expire_time)) : values.BindNull();
  return values;
}

}  // namespace

PostgresIdentityStore::PostgresIdentityStore(std::shared_ptr<PostgresDatabase> database,
                                             std::chrono::nanoseconds max_away)
    : database_(std::move(database)),
      known_(*database_->watch, ChangeTopic::kIdentities, {.max_away = max_away}),
      // That nobody is known makes everyone an admin: it is used only while it is certain.
      any_(*database_->watch, ChangeTopic::kIdentities, {.max_away = std::chrono::seconds(0)}) {}

absl::StatusOr<std::unique_ptr<PostgresIdentityStore>> PostgresIdentityStore::Open(
    std::shared_ptr<PostgresDatabase> database, std::chrono::nanoseconds max_away) {
  absl::Status status = database->pool.WithConnection(
      [](PostgresConnection& connection) { return Migrate(connection, kMigrations); });
  if (!status.ok()) return status;
  return std::unique_ptr<PostgresIdentityStore>(
      new PostgresIdentityStore(std::move(database), max_away));
}

absl::StatusOr<std::string> PostgresIdentityStore::Create(Proof proof, const Principal& principal,
                                                          std::optional<SystemTime> expire_time) {
  absl::Status status = CheckPrincipal(principal);
  if (!status.ok()) return status;
  absl::StatusOr<std::string> token = proof == Proof::kToken ? NewToken() : std::string();
  if (!token.ok()) return token;
  status = database_->pool.InTransaction([&](PostgresConnection& connection) {
    return connection
        .Query(
            "INSERT INTO identity (token_sha256, common_name, name, tenant, role,"
            " create_time_ns, expire_time_ns) VALUES ($1, $2, $3, $4, $5, $6, $7)",
            ValuesOf(*token, principal, expire_time))
        .status();
  });
  known_.Forget();
  any_.Forget();
  if (absl::IsAlreadyExists(status)) return CertificateNameTaken(principal.name);
  if (!status.ok()) return status;
  return token;
}

absl::StatusOr<std::vector<IdentityRecord>> PostgresIdentityStore::List(std::int64_t after,
                                                                        int limit) {
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) -> absl::StatusOr<std::vector<IdentityRecord>> {
        absl::StatusOr<PostgresRows> rows = connection.Query(
            absl::StrCat(kIdentityColumns, "WHERE id > $1 ORDER BY id LIMIT $2").c_str(),
            PostgresValues().Bind(after).Bind(std::int64_t{limit}));
        if (!rows.ok()) return rows.status();
        std::vector<IdentityRecord> records;
        while (rows->Next()) {
          absl::StatusOr<IdentityRecord> record = Read(*rows);
          if (!record.ok()) return record.status();
          records.push_back(*std::move(record));
        }
        return records;
      });
}

absl::Status PostgresIdentityStore::Revoke(std::int64_t id) {
  absl::Status status = database_->pool.InTransaction([&](PostgresConnection& connection) {
    const absl::StatusOr<PostgresRows> rows = connection.Query(
        "UPDATE identity SET revoke_time_ns = COALESCE(revoke_time_ns, $1) WHERE id = $2",
        PostgresValues().Bind(NowNanoseconds()).Bind(id));
    if (!rows.ok()) return rows.status();
    return rows->count() == 0 ? NoSuchIdentity(id) : absl::OkStatus();
  });
  known_.Forget();
  any_.Forget();
  return status;
}

absl::StatusOr<Principal> PostgresIdentityStore::FindToken(absl::string_view token) {
  return Find("WHERE token_sha256 = $1", HashOfToken(token), ProofByToken());
}

absl::StatusOr<Principal> PostgresIdentityStore::FindCertificate(absl::string_view common_name) {
  const std::string what = ProofByCertificate(common_name);
  // Names that could not have been created may hold what the database takes for no text.
  if (!CheckId("name", common_name).ok()) return ProofNotKnown(what);
  return Find("WHERE common_name = $1 ORDER BY id DESC LIMIT 1", std::string(common_name), what);
}

absl::StatusOr<Principal> PostgresIdentityStore::Find(const std::string& where,
                                                      const std::string& key,
                                                      const std::string& what) {
  const absl::StatusOr<IdentityRecord> record = known_.Get(absl::StrCat(where, "\n", key), [&] {
    return database_->pool.WithConnection(
        [&](PostgresConnection& connection) -> absl::StatusOr<IdentityRecord> {
          absl::StatusOr<PostgresRows> rows = connection.Query(
              absl::StrCat(kIdentityColumns, where).c_str(), PostgresValues().Bind(key));
          if (!rows.ok()) return rows.status();
          if (!rows->Next()) return ProofNotKnown(what);
          return Read(*rows);
        });
  });
  if (!record.ok()) return record.status();
  return ValidPrincipal(*record, what, std::chrono::system_clock::now());
}

absl::StatusOr<bool> PostgresIdentityStore::HasAny() {
  return any_.Get("", [&] {
    return database_->pool.WithConnection(
        [&](PostgresConnection& connection) -> absl::StatusOr<bool> {
          absl::StatusOr<PostgresRows> rows = connection.Query("SELECT 1 FROM identity LIMIT 1");
          if (!rows.ok()) return rows.status();
          return rows->Next();
        });
  });
}

}  // namespace dcloc::server
