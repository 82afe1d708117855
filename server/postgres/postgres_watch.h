#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "absl/status/status.h"
#include "server/base/files.h"
#include "server/postgres/postgres_pool.h"

namespace dcloc::server {

/// What may change in a database behind a server's back.
enum class ChangeTopic { kCatalogue, kIdentities };
inline constexpr std::size_t kChangeTopicCount = 2;

/// What a server knows of the changes of one topic.
struct ChangeState {
  std::int64_t number = 0;                               ///< of the last change
  std::chrono::steady_clock::time_point confirm_time{};  ///< when it was the last one for certain
  bool fresh = false;                                    ///< confirmed within `kMaxChangeDelay`
};

/// How long a change of one server may stay unseen by another one, at most.
inline constexpr std::chrono::milliseconds kMaxChangeDelay{900};

/// Watches one database on a connection and a thread of its own: which changes there were, and
/// whether it is there at all. NOTIFY wakes it, as a hint. The truth is a row with the number of
/// the last change, which is read again each time and every `kInterval`. Thread-safe.
class PostgresWatch {
 public:
  static constexpr std::chrono::milliseconds kInterval{300};

  /// Work on the watch's connection. `is_new`: it is a new one, so the database was away.
  using Task = std::function<absl::Status(PostgresConnection& connection, bool is_new)>;

  /// Makes what it needs in the database. `pool` outlives it.
  static absl::StatusOr<std::unique_ptr<PostgresWatch>> Open(PostgresPool& pool);
  ~PostgresWatch();

  ChangeState state(ChangeTopic topic) const;

  /// Runs `task` after each look at the changes, until the result is destroyed; that waits for one
  /// that runs.
  std::shared_ptr<void> Add(Task task);

  /// Looks, and runs the tasks, at once.
  void Wake();

 private:
  explicit PostgresWatch(PostgresPool& pool);

  void Run(const std::stop_token& stop);
  absl::Status Look(bool is_new);
  absl::Status Connect();
  absl::Status ReadNumbers();
  void Pause(std::chrono::milliseconds duration);

  PostgresPool& pool_;
  FileDescriptor wake_;  ///< an eventfd
  std::unique_ptr<PostgresConnection> connection_;
  mutable std::mutex mutex_;
  std::array<ChangeState, kChangeTopicCount> states_;
  std::mutex tasks_mutex_;
  std::list<Task> tasks_;
  std::jthread thread_;  ///< last: it uses the others
};

}  // namespace dcloc::server
