#include "server/convert/learned_rig.h"

#include <cmath>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/base/check.h"
#include "server/base/status.h"

namespace dcloc::server::convert {
namespace {

// A rig has far fewer radars; a message may have any number.
constexpr int kMaxLearnedRadars = 64;

std::optional<ScalarEstimate> Known(bool is_there, const v1::LearnedValue& value) {
  if (!is_there) return std::nullopt;
  // A sigma that is negative must not become a variance that is not.
  const double variance = value.sigma() > 0.0 ? value.sigma() * value.sigma() : std::nan("");
  return ScalarEstimate{value.value(), variance};
}

template <typename Mutable, typename Clear>
void SetKnown(const std::optional<ScalarEstimate>& known, const Mutable& mutable_value,
              const Clear& clear) {
  if (!known) return clear();
  v1::LearnedValue* value = mutable_value();
  value->set_value(known->value);
  value->set_sigma(std::sqrt(known->variance));
}

void SetRadar(const RadarKnowledge& radar, v1::LearnedRadar* message) {
  message->set_radar_id(radar.radar_id);
  SetKnown(
      radar.mount_yaw_error, [&] { return message->mutable_mount_yaw_error_rad(); },
      [&] { message->clear_mount_yaw_error_rad(); });
  SetKnown(
      radar.clock_ahead, [&] { return message->mutable_clock_ahead_s(); },
      [&] { message->clear_clock_ahead_s(); });
  SetKnown(
      radar.stamp_delay, [&] { return message->mutable_stamp_delay_s(); },
      [&] { message->clear_stamp_delay_s(); });
  SetKnown(
      radar.range_bias_error, [&] { return message->mutable_range_bias_error_m(); },
      [&] { message->clear_range_bias_error_m(); });
  SetKnown(
      radar.beta_error, [&] { return message->mutable_beta_error_s(); },
      [&] { message->clear_beta_error_s(); });
}

}  // namespace

absl::StatusOr<RigKnowledge> FromProto(const v1::LearnedRig& message, absl::string_view field) {
  absl::Status status = CheckIntegerBetween(absl::StrCat(field, ".radars"), message.radars_size(),
                                            0, kMaxLearnedRadars);
  if (!status.ok()) return status;
  RigKnowledge known{
      .odometry_delay = Known(message.has_odometry_delay_s(), message.odometry_delay_s()),
      .wheel_scale = Known(message.has_wheel_scale(), message.wheel_scale()),
      .yaw_rate_correction =
          Known(message.has_yaw_rate_correction_radps(), message.yaw_rate_correction_radps())};
  for (const v1::LearnedRadar& radar : message.radars()) {
    status.Update(CheckId(absl::StrCat(field, ".radars.radar_id"), radar.radar_id()));
    known.radars.push_back(
        {.radar_id = radar.radar_id(),
         .mount_yaw_error = Known(radar.has_mount_yaw_error_rad(), radar.mount_yaw_error_rad()),
         .clock_ahead = Known(radar.has_clock_ahead_s(), radar.clock_ahead_s()),
         .stamp_delay = Known(radar.has_stamp_delay_s(), radar.stamp_delay_s()),
         .range_bias_error = Known(radar.has_range_bias_error_m(), radar.range_bias_error_m()),
         .beta_error = Known(radar.has_beta_error_s(), radar.beta_error_s())});
  }
  status.Update(WithPrefix(absl::StrCat(field, ": "), Validate(known)));
  if (!status.ok()) return status;
  return known;
}

void ToProto(const RigKnowledge& known, v1::LearnedRig* message) {
  message->clear_radars();
  for (const RadarKnowledge& radar : known.radars) SetRadar(radar, message->add_radars());
  SetKnown(
      known.odometry_delay, [&] { return message->mutable_odometry_delay_s(); },
      [&] { message->clear_odometry_delay_s(); });
  SetKnown(
      known.wheel_scale, [&] { return message->mutable_wheel_scale(); },
      [&] { message->clear_wheel_scale(); });
  SetKnown(
      known.yaw_rate_correction, [&] { return message->mutable_yaw_rate_correction_radps(); },
      [&] { message->clear_yaw_rate_correction_radps(); });
}

}  // namespace dcloc::server::convert
