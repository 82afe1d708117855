#pragma once

#include <chrono>
#include <mutex>

namespace dcloc::server {

/// A token bucket with a burst of one second: events that come faster than `rate_hz` for longer are
/// refused. Thread-safe; its lock is held for a few additions.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// Takes a token at `now`; false when none is left. `rate_hz` may change between calls; 0 is no
  /// limit.
  bool Take(double rate_hz, Clock::time_point now);

 private:
  std::mutex mutex_;
  bool begun_ = false;
  double left_ = 0.0;
  Clock::time_point last_;
};

}  // namespace dcloc::server
