#include "server/maps/catalogue/postgres_holds.h"

#include <chrono>
#include <map>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "server/base/status.h"
#include "server/maps/catalogue/catalogue_errors.h"
#include "server/maps/catalogue/postgres_hold_rows.h"
#include "server/postgres/postgres_error.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr std::chrono::seconds kRenewalInterval(3);

}  // namespace

/// What this process holds. Counts of 0 and given-back files are what the database is not told yet.
struct PostgresHolds::State {
  struct FileHold {
    std::string holder;
    std::int64_t token = 0;
  };

  /// Held while the database is told of holds: a row that was given back is not deleted after it
  /// was taken again. Taken before `mutex`.
  std::mutex telling;

  mutable std::mutex mutex;
  std::set<std::string> holders;
  std::map<VersionHoldKey, int> counts;  ///< of users
  std::map<std::string, FileHold> files;
  std::vector<std::int64_t> given_back_files;  ///< tokens

  void GiveBackVersion(const VersionHoldKey& key) {
    const std::lock_guard lock(mutex);
    --counts[key];
  }

  void GiveBackFile(const std::string& sha256, std::int64_t token) {
    const std::lock_guard lock(mutex);
    files.erase(sha256);
    given_back_files.push_back(token);
  }

  /// With `telling` held, and outside of a transaction, as what is told is then forgotten here.
  absl::Status DeleteReleased(PostgresConnection& connection) {
    std::vector<VersionHoldKey> versions;
    std::vector<std::int64_t> tokens;
    {
      const std::lock_guard lock(mutex);
      for (const auto& [key, count] : counts) {
        if (count == 0) versions.push_back(key);
      }
      tokens = given_back_files;
    }
    for (const VersionHoldKey& key : versions) {
      if (absl::Status status = DeleteVersionHold(connection, key); !status.ok()) return status;
    }
    for (const std::int64_t token : tokens) {
      if (absl::Status status = DeleteFileHold(connection, token); !status.ok()) return status;
    }
    const std::lock_guard lock(mutex);
    // Nobody has taken one of these again meanwhile; more may have been given back.
    for (const VersionHoldKey& key : versions) counts.erase(key);
    given_back_files.erase(given_back_files.begin(),
                           given_back_files.begin() + static_cast<std::ptrdiff_t>(tokens.size()));
    return absl::OkStatus();
  }
};

PostgresHolds::PostgresHolds(std::shared_ptr<PostgresDatabase> database)
    : database_(std::move(database)), state_(std::make_shared<State>()) {
  task_ = database_->watch->Add(
      [this](PostgresConnection& connection, bool is_new) { return Keep(connection, is_new); });
}

PostgresHolds::~PostgresHolds() {
  task_.reset();
  std::set<std::string> holders;
  {
    const std::lock_guard lock(state_->mutex);
    holders = state_->holders;
  }
  const absl::Status status = database_->pool.InTransaction([&](PostgresConnection& connection) {
    absl::Status ended;
    for (const std::string& holder : holders) ended.Update(DeleteHolder(connection, holder));
    return ended;
  });
  // They end with their lease.
  if (!status.ok()) spdlog::warn("holds not given back reason={}", Quoted(status.message()));
}

absl::StatusOr<Hold> PostgresHolds::HoldVersion(absl::string_view map_name, std::int64_t version,
                                                absl::string_view holder, bool is_known) {
  const VersionHoldKey key{std::string(map_name), version, std::string(holder)};
  const auto hold = [&] {
    ++state_->counts[key];
    return Hold([state = state_, key] { state->GiveBackVersion(key); });
  };
  {
    const std::lock_guard lock(state_->mutex);
    state_->holders.insert(key.holder);
    const auto held = state_->counts.find(key);
    if (held != state_->counts.end() && held->second > 0) return hold();
  }
  const std::lock_guard telling(state_->telling);
  const absl::Status status = database_->pool.InTransaction(
      [&](PostgresConnection& connection) { return InsertVersionHold(connection, key); });
  const std::lock_guard lock(state_->mutex);
  if (status.ok() || (is_known && IsAway(status))) return hold();
  // The row may be there: then it is given back.
  if (absl::IsInternal(status)) state_->counts.try_emplace(key, 0);
  return status;
}

absl::StatusOr<Hold> PostgresHolds::HoldFile(absl::string_view sha256, absl::string_view holder) {
  const std::string file(sha256);
  const std::lock_guard telling(state_->telling);
  bool held_here = false;
  {
    const std::lock_guard lock(state_->mutex);
    state_->holders.insert(std::string(holder));
    held_here = state_->files.contains(file);
  }
  absl::Status status = database_->pool.WithConnection(
      [&](PostgresConnection& connection) { return state_->DeleteReleased(connection); });
  if (!status.ok()) return status;
  std::int64_t token = 0;
  status = database_->pool.InTransaction([&](PostgresConnection& connection) {
    const absl::StatusOr<std::int64_t> inserted =
        InsertFileHold(connection, sha256, holder, held_here);
    if (inserted.ok()) token = *inserted;
    return inserted.status();
  });
  if (!status.ok()) return status;
  const std::lock_guard lock(state_->mutex);
  state_->files[file] = {.holder = std::string(holder), .token = token};
  return Hold([state = state_, file, token] { state->GiveBackFile(file, token); });
}

absl::Status PostgresHolds::DeleteReleased() {
  const std::lock_guard telling(state_->telling);
  return database_->pool.WithConnection(
      [&](PostgresConnection& connection) { return state_->DeleteReleased(connection); });
}

absl::Status PostgresHolds::CheckFileHold(PostgresConnection& connection,
                                          absl::string_view sha256) const {
  std::optional<std::int64_t> token;
  {
    const std::lock_guard lock(state_->mutex);
    const auto held = state_->files.find(std::string(sha256));
    if (held != state_->files.end()) token = held->second.token;
  }
  return token ? CheckFileToken(connection, sha256, *token) : absl::OkStatus();
}

absl::Status PostgresHolds::Keep(PostgresConnection& connection, bool is_new) {
  const std::lock_guard telling(state_->telling);
  const auto now = std::chrono::steady_clock::now();
  if (is_new || now >= next_renewal_) {
    absl::Status status = RenewLeases(connection, is_new);
    if (!status.ok()) return status;
    next_renewal_ = now + kRenewalInterval;
  }
  return state_->DeleteReleased(connection);
}

absl::Status PostgresHolds::RenewLeases(PostgresConnection& connection, bool is_new) {
  std::set<std::string> holders;
  {
    const std::lock_guard lock(state_->mutex);
    holders = state_->holders;
  }
  bool some_ended = is_new;  // also what was held while the database was away
  for (const std::string& holder : holders) {
    const absl::StatusOr<bool> lived = RenewLease(connection, holder);
    if (!lived.ok()) return lived.status();
    some_ended = some_ended || !*lived;
  }
  absl::Status status = some_ended ? InsertAll(connection) : absl::OkStatus();
  return status.ok() ? DeleteDeadHolders(connection) : status;
}

absl::Status PostgresHolds::InsertAll(PostgresConnection& connection) {
  std::vector<VersionHoldKey> held;
  {
    const std::lock_guard lock(state_->mutex);
    for (const auto& [key, count] : state_->counts) {
      if (count > 0) held.push_back(key);
    }
  }
  for (const VersionHoldKey& key : held) {
    const absl::StatusOr<bool> is_there = InsertVersionHoldAgain(connection, key);
    if (!is_there.ok()) return is_there.status();
    if (*is_there) continue;
    // Its sessions go on with their copy in memory.
    spdlog::warn("a version in use was deleted while the database was away map={} version={}",
                 key.map_name, key.version);
  }
  return absl::OkStatus();
}

}  // namespace dcloc::server
