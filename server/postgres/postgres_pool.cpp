#include "server/postgres/postgres_pool.h"

#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/postgres/postgres_error.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

PostgresPool::PostgresPool(PostgresOptions options) : options_(std::move(options)) {}

void PostgresPool::NoteBack() {
  if (away_.exchange(false)) spdlog::info("database back");
}

void PostgresPool::NoteAway(const absl::Status& reason) {
  const std::lock_guard lock(mutex_);
  next_try_ = Clock::now() + kRetryInterval;
  if (away_.exchange(true)) return;
  spdlog::error("database away address={} reason={}", ShownAddress(options_.address),
                Quoted(AwayReason(reason)));
}

bool PostgresPool::IsLostStatus(const absl::Status& status) { return IsAway(status); }

absl::StatusOr<PostgresPool::Connection> PostgresPool::Take() {
  const Clock::time_point deadline = Clock::now() + options_.statement_timeout;
  std::unique_lock lock(mutex_);
  while (true) {
    if (away_) {
      if (Clock::now() < next_try_) return AwayError("away a moment ago");
      next_try_ = Clock::now() + kRetryInterval;  // this caller finds out, the others do not wait
    }
    if (!idle_.empty()) {
      Connection connection = std::move(idle_.back());
      idle_.pop_back();
      if (connection->IsIdle()) return connection;
      --open_count_;
      continue;
    }
    if (open_count_ < options_.max_connection_count) {
      ++open_count_;
      lock.unlock();
      return Connect();
    }
    if (freed_.wait_until(lock, deadline) == std::cv_status::timeout) {
      return absl::UnavailableError(absl::StrFormat(
          "all %d connections to the database of the catalogue are busy; try again", open_count_));
    }
  }
}

absl::StatusOr<PostgresPool::Connection> PostgresPool::Connect() {
  absl::StatusOr<Connection> connection = OutOfMemory();
  WithinMemory([&] { connection = PostgresConnection::Open(options_); }).IgnoreError();
  if (connection.ok()) {
    NoteBack();
    return connection;
  }
  NoteAway(connection.status());
  const std::lock_guard lock(mutex_);
  --open_count_;
  freed_.notify_one();
  return connection;
}

void PostgresPool::GiveBack(Connection connection, const absl::Status& status) {
  const std::lock_guard lock(mutex_);
  if (connection->IsIdle()) {
    idle_.push_back(std::move(connection));
  } else {
    --open_count_;
  }
  if (IsAway(status)) {
    // The others may be lost too, without knowing it yet: the next call makes a new one.
    open_count_ -= static_cast<int>(idle_.size());
    idle_.clear();
  }
  freed_.notify_all();
}

absl::Status PostgresPool::Begin(PostgresConnection& connection) {
  return connection.Query("BEGIN").status();
}

absl::Status PostgresPool::End(PostgresConnection& connection, const absl::Status& status) {
  if (!status.ok()) {
    connection.Query("ROLLBACK").status().IgnoreError();  // else the connection is not used again
    return status;
  }
  const absl::Status committed = connection.Query("COMMIT").status();
  if (!IsAway(committed)) return committed;
  return absl::InternalError(
      "the database of the catalogue was lost while a change was committed; look whether it was "
      "made");
}

}  // namespace dcloc::server
