#pragma once

#include <chrono>
#include <mutex>

namespace dcloc::server {

/// A token bucket that holds one second's worth: what comes faster than `rate_hz` for longer is
/// refused. Thread-safe; its lock is held for a few additions.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// Takes one at `now`; false when there is none left. `rate_hz` may change between calls; 0 is no
  /// limit.
  bool Take(double rate_hz, Clock::time_point now);

 private:
  std::mutex mutex_;
  bool begun_ = false;
  double left_ = 0.0;
  Clock::time_point last_;
};

}  // namespace dcloc::server
