#pragma once

#include <chrono>
#include <optional>

#include "core/radar/scan.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// Since when a vehicle reports the same velocity, to the last bit in speed and yaw rate. While it
/// moves, sources that work seldom repeat themselves, and a bus that is frozen does nothing else.
/// One that is repeated and no longer true was true when it first came, and is as old as that.
class HeldVelocity {
 public:
  /// The vehicle reports `velocity` at `stamp`, which is not before the last one's. What is 0 is
  /// never old: vehicles stand, and drive straight ahead.
  void OnReported(Stamp stamp, const EgoVelocity& velocity) {
    const double speed_mps = velocity.linear_mps.x();
    const double yaw_rate_radps = velocity.angular_radps.z();
    const bool repeats = since_ && speed_mps == speed_mps_ && yaw_rate_radps == yaw_rate_radps_ &&
                         speed_mps != 0.0 && yaw_rate_radps != 0.0;
    if (!repeats) {
      since_ = stamp;
      is_contradicted_ = false;
    }
    speed_mps_ = speed_mps;
    yaw_rate_radps_ = yaw_rate_radps;
    repeated_for_ = stamp - *since_;
  }

  /// The vehicle has moved away from what it reports.
  void OnContradicted() { is_contradicted_ = repeated_for_ > std::chrono::nanoseconds(0); }

  /// How old the newest velocity is: none, as long as nothing has contradicted it.
  std::chrono::nanoseconds age() const {
    return is_contradicted_ ? repeated_for_ : std::chrono::nanoseconds(0);
  }

 private:
  std::optional<Stamp> since_;
  double speed_mps_ = 0.0;
  double yaw_rate_radps_ = 0.0;
  std::chrono::nanoseconds repeated_for_{0};
  bool is_contradicted_ = false;
};

}  // namespace dcloc
