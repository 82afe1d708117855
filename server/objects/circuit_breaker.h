#pragma once

#include <atomic>
#include <chrono>
#include <mutex>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dcloc::server {

/// Whether an object store is away. Once it is, one caller at a time finds out again and again
/// whether it is back, and all others fail at once. So nobody waits long for a store that is away,
/// and nobody has to tell that it is back. Thread-safe.
class CircuitBreaker {
 public:
  using Clock = std::chrono::steady_clock;

  /// `interval`: between two looks.
  explicit CircuitBreaker(std::chrono::milliseconds interval) : interval_(interval) {}

  /// How a caller may pass.
  enum class Pass { kFree, kProbe };

  /// `kFree`: it answered last time. `kProbe`: this caller finds out, and must call `Note`. Errors
  /// of `ObjectStoreError`: it is away.
  absl::StatusOr<Pass> Enter();

  /// What came of it: OK when the store has answered. Logs when that has changed.
  void Note(const absl::Status& outcome);

  bool away() const { return away_; }

 private:
  const std::chrono::milliseconds interval_;
  std::mutex mutex_;
  std::atomic<bool> away_ = false;
  bool probe_under_way_ = false;
  Clock::time_point next_probe_{};
};

}  // namespace dcloc::server
