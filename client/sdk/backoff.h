#pragma once

#include <chrono>
#include <random>

namespace dcloc::client {

/// How long to wait before the next attempt: twice as long each time, with jitter, so that a fleet
/// does not reconnect all at once.
class Backoff {
 public:
  using Duration = std::chrono::duration<double, std::milli>;

  Backoff(Duration initial, Duration max)
      : initial_(initial), max_(max), next_(initial), random_(std::random_device{}()) {}

  /// Between half and all of the step.
  Duration Next() {
    const Duration step = next_;
    next_ = std::min(max_, next_ * 2.0);
    return step * std::uniform_real_distribution(0.5, 1.0)(random_);
  }

  void Reset() { next_ = initial_; }

 private:
  Duration initial_;
  Duration max_;
  Duration next_;
  std::mt19937 random_;
};

}  // namespace dcloc::client
