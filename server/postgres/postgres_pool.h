#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/base/within_memory.h"
#include "server/postgres/postgres_connection.h"

namespace dcloc::server {

/// At most so many connections to one database, made when they are needed and kept. Thread-safe.
///
/// Once the database cannot be reached, calls fail at once, without waiting, until it is known to
/// be back: `NoteBack` says so, or one caller after `kRetryInterval` finds out. So nobody waits
/// long for a database that is away.
class PostgresPool {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kRetryInterval{1000};

  explicit PostgresPool(PostgresOptions options);

  const PostgresOptions& options() const { return options_; }

  /// Runs `read(connection)`, which does not change anything; again with another connection when
  /// the first one turns out to be lost.
  template <typename Read>
  auto WithConnection(const Read& read) -> decltype(read(std::declval<PostgresConnection&>())) {
    auto result = RunOnce(read);
    return IsLost(result) ? RunOnce(read) : std::move(result);
  }

  /// Runs `change(connection)` in a transaction, which is committed when it returns OK.
  /// Unavailable: nothing was changed. Internal when the connection is lost while it is committed:
  /// then the change may have been made or not.
  template <typename Change>
  absl::Status InTransaction(const Change& change) {
    absl::StatusOr<Connection> connection = Take();
    if (!connection.ok()) return connection.status();
    absl::Status status = WithinMemory([&] {
      absl::Status changed = Begin(**connection);
      if (changed.ok()) changed = change(**connection);
      return End(**connection, changed);
    });
    GiveBack(*std::move(connection), status);
    return status;
  }

  /// The database answers again.
  void NoteBack();

  /// It does not; `reason` goes into the log, once.
  void NoteAway(const absl::Status& reason);

  bool away() const { return away_; }

 private:
  using Connection = std::unique_ptr<PostgresConnection>;

  template <typename Read>
  auto RunOnce(const Read& read) -> decltype(read(std::declval<PostgresConnection&>())) {
    absl::StatusOr<Connection> connection = Take();
    if (!connection.ok()) return connection.status();
    decltype(read(**connection)) result = OutOfMemory();
    WithinMemory([&] { result = read(**connection); }).IgnoreError();
    GiveBack(*std::move(connection), StatusOf(result));
    return result;
  }

  static const absl::Status& StatusOf(const absl::Status& status) { return status; }
  template <typename Value>
  static const absl::Status& StatusOf(const absl::StatusOr<Value>& result) {
    return result.status();
  }
  template <typename Result>
  bool IsLost(const Result& result) {
    return IsLostStatus(StatusOf(result)) && !away_;
  }
  static bool IsLostStatus(const absl::Status& status);

  absl::StatusOr<Connection> Take();
  absl::StatusOr<Connection> Connect();
  void GiveBack(Connection connection, const absl::Status& status);
  static absl::Status Begin(PostgresConnection& connection);
  static absl::Status End(PostgresConnection& connection, const absl::Status& status);

  const PostgresOptions options_;
  std::atomic<bool> away_ = false;
  std::mutex mutex_;
  std::condition_variable freed_;
  std::vector<Connection> idle_;
  int open_count_ = 0;  ///< idle or in use
  Clock::time_point next_try_{};
};

}  // namespace dcloc::server
