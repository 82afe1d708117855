#include "client/cli/remote/learned_rig.h"

#include <google/protobuf/util/json_util.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/terminal.h"
#include "core/geometry/degrees.h"

namespace dcloc::cli {
namespace {

// Some hundred bytes a radar; anything longer is something else.
constexpr std::uintmax_t kMaxFile_bytes = 1U << 20U;

void Set(const ScalarEstimate& known, v1::LearnedValue* message) {
  message->set_value(known.value);
  message->set_sigma(std::sqrt(known.variance));
}

ScalarEstimate Known(const v1::LearnedValue& message) {
  return {message.value(), message.sigma() * message.sigma()};
}

std::string Line(const char* what, const v1::LearnedValue& value, double factor, const char* unit) {
  return absl::StrFormat("  %s %.4g +- %.2g%s\n", what, factor * value.value(),
                         factor * value.sigma(), unit);
}

}  // namespace

v1::LearnedRig ToProto(const RigKnowledge& known) {
  v1::LearnedRig message;
  for (const RadarKnowledge& radar : known.radars) {
    v1::LearnedRadar& added = *message.add_radars();
    added.set_radar_id(radar.radar_id);
    if (radar.mount_yaw_error) Set(*radar.mount_yaw_error, added.mutable_mount_yaw_error_rad());
    if (radar.clock_ahead) Set(*radar.clock_ahead, added.mutable_clock_ahead_s());
    if (radar.stamp_delay) Set(*radar.stamp_delay, added.mutable_stamp_delay_s());
    if (radar.range_bias_error) Set(*radar.range_bias_error, added.mutable_range_bias_error_m());
    if (radar.beta_error) Set(*radar.beta_error, added.mutable_beta_error_s());
  }
  if (known.odometry_delay) Set(*known.odometry_delay, message.mutable_odometry_delay_s());
  if (known.wheel_scale) Set(*known.wheel_scale, message.mutable_wheel_scale());
  if (known.yaw_rate_correction) {
    Set(*known.yaw_rate_correction, message.mutable_yaw_rate_correction_radps());
  }
  return message;
}

RigKnowledge FromProto(const v1::LearnedRig& message) {
  RigKnowledge known;
  for (const v1::LearnedRadar& radar : message.radars()) {
    RadarKnowledge& added = known.radars.emplace_back();
    added.radar_id = radar.radar_id();
    if (radar.has_mount_yaw_error_rad()) added.mount_yaw_error = Known(radar.mount_yaw_error_rad());
    if (radar.has_clock_ahead_s()) added.clock_ahead = Known(radar.clock_ahead_s());
    if (radar.has_stamp_delay_s()) added.stamp_delay = Known(radar.stamp_delay_s());
    if (radar.has_range_bias_error_m()) added.range_bias_error = Known(radar.range_bias_error_m());
    if (radar.has_beta_error_s()) added.beta_error = Known(radar.beta_error_s());
  }
  if (message.has_odometry_delay_s()) known.odometry_delay = Known(message.odometry_delay_s());
  if (message.has_wheel_scale()) known.wheel_scale = Known(message.wheel_scale());
  if (message.has_yaw_rate_correction_radps()) {
    known.yaw_rate_correction = Known(message.yaw_rate_correction_radps());
  }
  return known;
}

absl::StatusOr<std::optional<v1::LearnedRig>> ReadLearnedRig(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return std::nullopt;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return absl::UnknownError(absl::StrCat(path, ": ", error.message()));
  if (size > kMaxFile_bytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": has ", size, " bytes; a learned rig has at most ", kMaxFile_bytes));
  }
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file.good() && !file.eof()) return absl::UnknownError(absl::StrCat(path, ": not readable"));
  v1::LearnedRig message;
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;  // of a newer client
  const auto status = google::protobuf::util::JsonStringToMessage(text, &message, options);
  if (!status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": is no learned rig: ", std::string(status.message())));
  }
  return message;
}

absl::Status WriteLearnedRig(const std::string& path, const v1::LearnedRig& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(message, &text, options).ok()) {
    return absl::InternalError(absl::StrCat(path, ": what was learned is not printable"));
  }
  return WriteFileAtomically(path, std::as_bytes(std::span(text)));
}

std::string LearnedRigText(const v1::LearnedRig& message) {
  std::string text = "Learned of the rig:\n";
  if (message.has_odometry_delay_s()) {
    text += Line("the velocity is late by", message.odometry_delay_s(), 1.0, " s");
  }
  if (message.has_wheel_scale()) text += Line("wheel scale", message.wheel_scale(), 1.0, "");
  if (message.has_yaw_rate_correction_radps()) {
    text +=
        Line("yaw rate is corrected by", message.yaw_rate_correction_radps(), kDegPerRad, " deg/s");
  }
  for (const v1::LearnedRadar& radar : message.radars()) {
    text += absl::StrCat("  ", Visible(radar.radar_id()), ":\n");
    if (radar.has_mount_yaw_error_rad()) {
      text += Line("  looks further left by", radar.mount_yaw_error_rad(), kDegPerRad, " deg");
    }
    if (radar.has_clock_ahead_s()) {
      text += Line("  clock is ahead by", radar.clock_ahead_s(), 1.0, " s");
    }
    if (radar.has_stamp_delay_s()) {
      text += Line("  stamps its scans late by", radar.stamp_delay_s(), 1.0, " s");
    }
    if (radar.has_range_bias_error_m()) {
      text += Line("  ranges are too long by", radar.range_bias_error_m(), 1.0, " m");
    }
    if (radar.has_beta_error_s()) {
      text += Line("  beta is too small by", radar.beta_error_s(), 1.0, " s");
    }
  }
  return text;
}

}  // namespace dcloc::cli
