#include "server/replicas/postgres_replica_directory.h"

#include <utility>

#include "server/base/random_name.h"
#include "server/base/status.h"
#include "server/postgres/postgres_migrations.h"
#include "server/replicas/replica_address.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kRenewalInterval(3);
constexpr std::chrono::seconds kLookInterval(1);

constexpr const char* kSteps[] = {R"(
CREATE TABLE dcloc.replica (
  address text COLLATE "C" PRIMARY KEY,
  lease_end timestamptz NOT NULL
);
)",
                                  R"(
ALTER TABLE dcloc.replica ADD COLUMN owner text COLLATE "C" NOT NULL DEFAULT '';
)"};
constexpr PostgresMigrations kMigrations{.part = "replicas", .steps = kSteps};

}  // namespace

absl::StatusOr<std::unique_ptr<PostgresReplicaDirectory>> PostgresReplicaDirectory::Open(
    std::shared_ptr<PostgresDatabase> database) {
  absl::Status status = database->pool.WithConnection(
      [](PostgresConnection& connection) { return Migrate(connection, kMigrations); });
  if (!status.ok()) return status;
  absl::StatusOr<std::string> owner = RandomName(128, "a replica");
  if (!owner.ok()) return owner.status();
  return std::unique_ptr<PostgresReplicaDirectory>(
      new PostgresReplicaDirectory(std::move(database), *std::move(owner)));
}

PostgresReplicaDirectory::PostgresReplicaDirectory(std::shared_ptr<PostgresDatabase> database,
                                                   std::string owner)
    : database_(std::move(database)), owner_(std::move(owner)) {
  task_ = database_->watch->Add(
      [this](PostgresConnection& connection, bool is_new) { return Keep(connection, is_new); });
}

PostgresReplicaDirectory::~PostgresReplicaDirectory() {
  task_.reset();
  if (own_address_.empty()) return;
  const absl::Status status =
      database_->pool.WithConnection([this](PostgresConnection& connection) {
        return connection
            .Query("DELETE FROM replica WHERE address = $1 AND owner = $2",
                   PostgresValues().Bind(own_address_).Bind(owner_))
            .status();
      });
  // It ends with its lease.
  if (!status.ok()) spdlog::warn("replica not taken away reason={}", Quoted(status.message()));
}

void PostgresReplicaDirectory::Announce(const std::string& address) {
  {
    const std::lock_guard lock(mutex_);
    own_address_ = address;
  }
  database_->watch->Wake();
}

std::vector<std::string> PostgresReplicaDirectory::Others() const {
  const std::lock_guard lock(mutex_);
  return others_;
}

std::string PostgresReplicaDirectory::own_address() const {
  const std::lock_guard lock(mutex_);
  return own_address_;
}

// Other tasks of the watch, as the holds of maps in use, must not wait for what is wrong with this
// one alone: only a lost connection is reported.
absl::Status PostgresReplicaDirectory::Keep(PostgresConnection& connection, bool is_new) {
  absl::Status status = RenewAndLook(connection, is_new);
  if (status.ok() || absl::IsUnavailable(status)) return status;
  spdlog::warn("replicas not kept reason={}", Quoted(status.message()));
  return absl::OkStatus();
}

absl::Status PostgresReplicaDirectory::RenewAndLook(PostgresConnection& connection, bool is_new) {
  if (own_address().empty()) return absl::OkStatus();
  const Clock::time_point now = Clock::now();
  if (is_new || now >= next_renewal_) {
    if (absl::Status status = Renew(connection); !status.ok()) return status;
    next_renewal_ = now + kRenewalInterval;
  }
  if (!is_new && now < next_look_) return absl::OkStatus();
  absl::StatusOr<std::vector<std::string>> others = ReadOthers(connection);
  if (!others.ok()) return others.status();
  next_look_ = now + kLookInterval;
  const std::lock_guard lock(mutex_);
  others_ = *std::move(others);
  return absl::OkStatus();
}

/// While the database was away nobody could renew a lease, so after its start all live for the time
/// of one.
absl::Status PostgresReplicaDirectory::Renew(PostgresConnection& connection) {
  absl::Status status =
      connection
          .Query(
              "DELETE FROM replica WHERE lease_end < clock_timestamp() AND owner <> $2"
              " AND pg_postmaster_start_time() < clock_timestamp() - $1::bigint * interval '1 s'",
              PostgresValues().Bind(std::int64_t{kLease.count()}).Bind(owner_))
          .status();
  if (!status.ok()) return status;
  // A row without an owner is of a server that knows none; it goes with its lease.
  const absl::StatusOr<PostgresRows> rows = connection.Query(
      "INSERT INTO replica (address, lease_end, owner)"
      " VALUES ($1, clock_timestamp() + $2::bigint * interval '1 s', $3)"
      " ON CONFLICT (address) DO UPDATE SET lease_end = excluded.lease_end"
      " WHERE replica.owner = excluded.owner",
      PostgresValues().Bind(own_address()).Bind(std::int64_t{kLease.count()}).Bind(owner_));
  if (!rows.ok()) return rows.status();
  NoteOwned(rows->count() > 0);
  return absl::OkStatus();
}

/// Each change is reported once.
void PostgresReplicaDirectory::NoteOwned(bool owned) {
  if (std::exchange(owned_, owned) == owned) return;
  if (owned) {
    spdlog::info("replica address taken address={}", own_address());
  } else {
    spdlog::warn(
        "replica address not taken address={} reason=\"another server has it, or had it up to {} s "
        "ago\"",
        own_address(), kLease.count());
  }
}

absl::StatusOr<std::vector<std::string>> PostgresReplicaDirectory::ReadOthers(
    PostgresConnection& connection) const {
  absl::StatusOr<PostgresRows> rows =
      connection.Query("SELECT address FROM replica WHERE address <> $1 ORDER BY address",
                       PostgresValues().Bind(own_address()));
  if (!rows.ok()) return rows.status();
  std::vector<std::string> others;
  while (rows->Next()) {
    std::string address = rows->NextText();
    if (IsReplicaAddress(address)) {
      others.push_back(std::move(address));
    } else {
      spdlog::warn("replica left out address={} reason=\"it is no HOST:PORT\"", Quoted(address));
    }
  }
  return others;
}

}  // namespace dcloc::server
