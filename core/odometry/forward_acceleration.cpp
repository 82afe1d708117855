#include "core/odometry/forward_acceleration.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

std::span<const OptionField<ForwardAccelerationOptions>> FieldsOf(
    const ForwardAccelerationOptions& /*options*/) {
  using O = ForwardAccelerationOptions;
  static constexpr OptionField<O> kFields[] = {
      {"smoothing_ms", &O::smoothing, 1, 1e5},
      {"max_gap_ms", &O::max_gap, 1, 1e5},
      {"max_mps2", &O::max_mps2, 0, 1000, "scans are taken as of one moment"},
  };
  return kFields;
}

absl::Status Validate(const ForwardAccelerationOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

void ForwardAcceleration::OnSpeed(Stamp stamp, double speed_mps) {
  if (last_ && stamp <= *last_) return;
  if (!last_ || stamp - *last_ > options_.max_gap) {
    acceleration_mps2_ = 0.0;
  } else {
    const double age_s = SecondsOf(stamp - *last_);
    const double share = 1.0 - std::exp(-age_s / SecondsOf(options_.smoothing));
    acceleration_mps2_ += share * ((speed_mps - speed_mps_) / age_s - acceleration_mps2_);
  }
  last_ = stamp;
  speed_mps_ = speed_mps;
}

double ForwardAcceleration::Gain_mps(std::chrono::nanoseconds duration) const {
  return SecondsOf(duration) *
         std::clamp(acceleration_mps2_, -options_.max_mps2, options_.max_mps2);
}

}  // namespace dcloc
