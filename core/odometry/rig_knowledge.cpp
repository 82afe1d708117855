#include "core/odometry/rig_knowledge.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

using MaybeKnown = std::optional<ScalarEstimate>;

constexpr double kMaxKnownSigma = 1e3;

absl::Status CheckKnown(const MaybeKnown& known, const std::string& name, double min, double max) {
  if (!known) return absl::OkStatus();
  if (!(known->value >= min && known->value <= max)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s is %g; it must lie in [%g, %g]", name, known->value, min, max));
  }
  const double sigma = std::sqrt(known->variance);
  if (!(sigma > 0.0 && sigma <= kMaxKnownSigma)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s has a sigma of %g; it must lie in (0, %g]", name, sigma, kMaxKnownSigma));
  }
  return absl::OkStatus();
}

bool Differs(const MaybeKnown& before, const MaybeKnown& now) {
  if (!now) return before.has_value();
  if (!before) return true;
  const double apart = now->value - before->value;
  return apart * apart > before->variance || 4.0 * now->variance < before->variance;
}

}  // namespace

RadarKnowledge& RigKnowledge::Of(const std::string& radar_id) {
  const auto found = std::ranges::find(radars, radar_id, &RadarKnowledge::radar_id);
  return found == radars.end() ? radars.emplace_back(RadarKnowledge{.radar_id = radar_id}) : *found;
}

const RadarKnowledge* RigKnowledge::Find(const std::string& radar_id) const {
  const auto found = std::ranges::find(radars, radar_id, &RadarKnowledge::radar_id);
  return found == radars.end() ? nullptr : &*found;
}

absl::Status Validate(const RigKnowledge& knowledge) {
  absl::Status status =
      CheckKnown(knowledge.odometry_delay, "odometry_delay_s", -kMaxKnownDelay_s, kMaxKnownDelay_s);
  status.Update(CheckKnown(knowledge.wheel_scale, "wheel_scale", kMinKnownScale, kMaxKnownScale));
  status.Update(CheckKnown(knowledge.yaw_rate_correction, "yaw_rate_correction_radps",
                           -kMaxKnownYawRateCorrection_radps, kMaxKnownYawRateCorrection_radps));
  std::set<std::string> ids;
  for (const RadarKnowledge& radar : knowledge.radars) {
    const auto name_of = [&](const char* field) {
      return absl::StrFormat("%s of radar '%s'", field, radar.radar_id);
    };
    if (!ids.insert(radar.radar_id).second) {
      status.Update(absl::InvalidArgumentError(
          absl::StrFormat("radar_id '%s' is there twice; it must be unique", radar.radar_id)));
    }
    status.Update(CheckKnown(radar.mount_yaw_error, name_of("mount_yaw_error_rad"),
                             -kMaxKnownMountYawError_rad, kMaxKnownMountYawError_rad));
    status.Update(CheckKnown(radar.stamp_delay, name_of("stamp_delay_s"), -kMaxKnownStampDelay_s,
                             kMaxKnownStampDelay_s));
    status.Update(CheckKnown(radar.range_bias_error, name_of("range_bias_error_m"),
                             -kMaxKnownRangeBiasError_m, kMaxKnownRangeBiasError_m));
    // Reported only; it must be a number all the same.
    status.Update(CheckKnown(radar.clock_ahead, name_of("clock_ahead_s"), -1e9, 1e9));
    status.Update(CheckKnown(radar.beta_error, name_of("beta_error_s"), -10.0, 10.0));
  }
  return status;
}

bool HasChanged(const RigKnowledge& before, const RigKnowledge& now) {
  if (Differs(before.odometry_delay, now.odometry_delay) ||
      Differs(before.wheel_scale, now.wheel_scale) ||
      Differs(before.yaw_rate_correction, now.yaw_rate_correction) ||
      before.radars.size() != now.radars.size()) {
    return true;
  }
  return std::ranges::any_of(now.radars, [&](const RadarKnowledge& radar) {
    const RadarKnowledge* last_reported = before.Find(radar.radar_id);
    return last_reported == nullptr ||
           Differs(last_reported->mount_yaw_error, radar.mount_yaw_error) ||
           Differs(last_reported->clock_ahead, radar.clock_ahead) ||
           Differs(last_reported->stamp_delay, radar.stamp_delay) ||
           Differs(last_reported->range_bias_error, radar.range_bias_error) ||
           Differs(last_reported->beta_error, radar.beta_error);
  });
}

}  // namespace dcloc
