#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "core/radar/scan.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// Since when a vehicle reports the same velocity, to the last bit in speed and yaw rate. While it
/// moves, sources that work seldom repeat themselves, and a bus that is frozen does nothing else.
/// One that is repeated and no longer true was true when it first came, and is as old as that. It
/// is no longer true where something contradicts it, or where the vehicle has changed its velocity
/// often and never repeated one for nearly as long.
class HeldVelocity {
 public:
  /// The vehicle reports `velocity` at `stamp`, which is not before the last one's. What is 0 is
  /// never old: vehicles stand, and drive straight ahead.
  void OnReported(Stamp stamp, const EgoVelocity& velocity) {
    const double speed_mps = velocity.linear_mps.x();
    const double yaw_rate_radps = velocity.angular_radps.z();
    const bool is_same = since_ && speed_mps == speed_mps_ && yaw_rate_radps == yaw_rate_radps_;
    const bool repeats = is_same && speed_mps != 0.0 && yaw_rate_radps != 0.0;
    if (repeats) {
      ++repeat_count_;
    } else {
      if (!is_contradicted_) usual_repeat_count_ = std::max(usual_repeat_count_, repeat_count_);
      if (since_ && !is_same) ++change_count_;
      since_ = stamp;
      is_contradicted_ = false;
      repeat_count_ = 0;
    }
    speed_mps_ = speed_mps;
    yaw_rate_radps_ = yaw_rate_radps;
    repeated_for_ = stamp - *since_;
  }

  /// Whether it is repeated for much longer than any velocity was before.
  bool IsUnusual() const {
    constexpr int kKnownAfter = 50;  // changes, so that what is usual is known
    constexpr int kMore = 2;         // repetitions than twice what is usual
    return change_count_ >= kKnownAfter && repeat_count_ > 2 * usual_repeat_count_ + kMore;
  }

  /// The vehicle has moved away from what it reports.
  void OnContradicted() {
    if (is_contradicted_ || repeated_for_ <= std::chrono::nanoseconds(0)) return;
    is_contradicted_ = true;
    trusted_for_ += repeated_for_;
  }

  /// For how long an old velocity was taken for a new one, until it was contradicted; said once.
  std::chrono::nanoseconds TakeTrusted() {
    return std::exchange(trusted_for_, std::chrono::nanoseconds(0));
  }

  /// How old the newest velocity is: none, as long as nothing has contradicted it.
  std::chrono::nanoseconds age() const {
    return is_contradicted_ ? repeated_for_ : std::chrono::nanoseconds(0);
  }

 private:
  std::optional<Stamp> since_;
  double speed_mps_ = 0.0;
  double yaw_rate_radps_ = 0.0;
  std::chrono::nanoseconds repeated_for_{0};
  std::chrono::nanoseconds trusted_for_{0};
  bool is_contradicted_ = false;
  int repeat_count_ = 0;        // of the newest velocity
  int usual_repeat_count_ = 0;  // the most of those before it that nothing contradicted
  int change_count_ = 0;
};

}  // namespace dcloc
