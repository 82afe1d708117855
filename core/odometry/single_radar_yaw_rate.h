#pragma once

#include <optional>

#include "core/geometry/forgetting_mean.h"
#include "core/odometry/scalar_estimate.h"

namespace dcloc {

/// What the Doppler of one radar says of the yaw rate.
struct SingleRadarReading {
  /// Without the angle by which the radar seems to look aside.
  ScalarEstimate yaw_rate;
  /// By how much it and the gyroscope's differ that a mount and side slip do not explain, >= 0.
  double beyond_gyroscope_radps = 0.0;
};

/// What the Doppler of one radar says of the yaw rate beside a gyroscope. A radar measures how fast
/// it moves sideways itself: by the vehicle's turn, times how far ahead of the vehicle frame's
/// origin it sits, if it looks where its mount says and the origin does not move sideways. By which
/// angle it seems to look elsewhere is learned while it agrees with the gyroscope. What is beyond
/// that, and beyond what a mount and a moving origin may add, contradicts the gyroscope
/// (METHOD section 15).
class SingleRadarYawRate {
 public:
  struct Gyroscope {
    double yaw_rate_radps;
    bool is_sound;  ///< of one that is not, nothing is learned
  };

  /// A moment's readings: the forward speed, Doppler's yaw rate by a radar that sits `ahead_m` of
  /// the origin, the gyroscope's. Nothing until the two have agreed for a while, or where the radar
  /// sits at the origin.
  std::optional<SingleRadarReading> OnYawRates(double speed_mps, double ahead_m,
                                               const ScalarEstimate& doppler,
                                               const Gyroscope& gyroscope);

  /// The radar looks elsewhere now, or its mount was corrected: by how much is learned anew.
  void OnMountChanged() { angle_rad_ = {}; }

 private:
  ForgettingMean angle_rad_;  // by which the radar seems to look aside
};

}  // namespace dcloc
