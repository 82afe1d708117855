#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"

namespace dcloc {

struct ForwardAccelerationOptions {
  /// The time constant with which changes of the speed are averaged.
  std::chrono::nanoseconds smoothing = std::chrono::milliseconds(500);
  /// Speeds further apart in time tell no acceleration.
  std::chrono::nanoseconds max_gap = std::chrono::milliseconds(500);
  double max_mps2 = 12.0;  ///< no vehicle speeds up or brakes harder
};
std::span<const OptionField<ForwardAccelerationOptions>> FieldsOf(
    const ForwardAccelerationOptions& options);
absl::Status Validate(const ForwardAccelerationOptions& options);

/// How fast Doppler's speed changes. Radars of a rig scan one after the other: while a vehicle
/// brakes, the earlier ones have measured a higher speed.
class ForwardAcceleration {
 public:
  explicit ForwardAcceleration(const ForwardAccelerationOptions& options = {})
      : options_(options) {}

  /// Doppler that is sound says this of `stamp`. One that is not after the last one is ignored.
  void OnSpeed(Stamp stamp, double speed_mps);

  /// By how much the vehicle is faster `duration` after a moment of late; negative where it brakes.
  double Gain_mps(std::chrono::nanoseconds duration) const;

 private:
  ForwardAccelerationOptions options_;
  std::optional<Stamp> last_;
  double speed_mps_ = 0.0;  // at the last stamp
  double acceleration_mps2_ = 0.0;
};

}  // namespace dcloc
