#include "core/odometry/speed_disagreement.h"

#include <cmath>

namespace dcloc {

std::span<const OptionField<SpeedDisagreementOptions>> FieldsOf(
    const SpeedDisagreementOptions& /*options*/) {
  using O = SpeedDisagreementOptions;
  static constexpr OptionField<O> kFields[] = {
      {"fading_ms", &O::fading, 1, 1e6},
      {"usual_time_constant_ms", &O::usual_time_constant, 1, 1e7},
      {"max_gap_ms", &O::max_gap, 1, 1e5},
  };
  return kFields;
}

absl::Status Validate(const SpeedDisagreementOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

// Gives the seconds since the last call; 0 after a gap.
double SpeedDisagreement::Fade(Stamp stamp) {
  const std::chrono::nanoseconds age = last_ ? stamp - *last_ : std::chrono::nanoseconds(0);
  last_ = stamp;
  distance_m_ *= std::exp(-SecondsOf(age) / SecondsOf(options_.fading));
  return age > options_.max_gap ? 0.0 : SecondsOf(age);
}

void SpeedDisagreement::OnSpeeds(Stamp stamp, double wheels_mps, double doppler_mps) {
  const double age_s = Fade(stamp);
  const double apart_mps = doppler_mps - wheels_mps;
  if (!usual_mps_) usual_mps_ = apart_mps;
  distance_m_ += age_s * (apart_mps - *usual_mps_);
  *usual_mps_ += age_s / SecondsOf(options_.usual_time_constant) * (apart_mps - *usual_mps_);
}

void SpeedDisagreement::OnDecided(Stamp stamp) { Fade(stamp); }

}  // namespace dcloc
