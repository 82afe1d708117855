#pragma once

#include <cmath>

#include "core/radar/scan.h"

namespace dcloc {

/// Whether a gyroscope says the same to the last bit, message after message, while the vehicle
/// drives. So does one that is dead, and one on a straight road that counts in steps. So what it
/// says is no evidence that it is sound.
class RepeatedYawRate {
 public:
  /// A message that is the same in its speed, too, may have been read twice, and says nothing new.
  void OnReported(const EgoVelocity& velocity) {
    const double speed_mps = velocity.linear_mps.x();
    const double yaw_rate_radps = velocity.angular_radps.z();
    if (speed_mps == speed_mps_ && yaw_rate_radps == yaw_rate_radps_) return;
    count_ = yaw_rate_radps == yaw_rate_radps_ ? count_ + 1 : 0;
    speed_mps_ = speed_mps;
    yaw_rate_radps_ = yaw_rate_radps;
  }

  explicit operator bool() const {
    constexpr int kMinCount = 3;
    constexpr double kDriving_mps = 1.0;
    return count_ >= kMinCount && std::abs(speed_mps_) >= kDriving_mps;
  }

 private:
  double speed_mps_ = 0.0;
  double yaw_rate_radps_ = 0.0;
  int count_ = 0;  // of repetitions
};

}  // namespace dcloc
