#include "client/sdk/pose/pose_estimate.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::client {

absl::Status Validate(const PoseOptions& options) {
  const std::pair<const char*, std::chrono::milliseconds> durations[] = {
      {"max_ahead", options.max_ahead},
      {"kept", options.kept},
      {"max_velocity_age", options.max_velocity_age}};
  for (const auto& [field, duration] : durations) {
    if (duration.count() > 0 && duration <= std::chrono::minutes(1)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("pose.", field, " is ", duration.count(), " ms; it must lie in [1, 60000]"));
  }
  const std::pair<const char*, double> numbers[] = {
      {"velocity_sigma_mps", options.velocity_sigma_mps},
      {"velocity_scale_sigma", options.velocity_scale_sigma},
      {"turn_rate_sigma_radps", options.turn_rate_sigma_radps},
      {"acceleration_sigma_mps2", options.acceleration_sigma_mps2},
      {"turn_acceleration_sigma_radps2", options.turn_acceleration_sigma_radps2},
      {"bleed_mps", options.bleed_mps},
      {"bleed_radps", options.bleed_radps},
      {"max_smoothed_m", options.max_smoothed_m}};
  for (const auto& [field, number] : numbers) {
    if (number > 0.0 && number <= 1000.0) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("pose.", field, " is ", number, "; it must lie in (0, 1000]"));
  }
  return absl::OkStatus();
}

}  // namespace dcloc::client
