#include "core/uncertainty/azimuth_signs.h"

#include <cmath>
#include <numbers>

namespace dcloc {

std::span<const OptionField<AzimuthSignOptions>> FieldsOf(const AzimuthSignOptions& /*options*/) {
  using O = AzimuthSignOptions;
  static constexpr OptionField<O> kFields[] = {
      {"scan_interval", &O::scan_interval, 1, 1'000},
      {"max_point_count", &O::max_point_count, 1, 1'000'000},
      {"min_pose_sigma_m", &O::min_pose_sigma_m, 0, 100, "poses are compared as exact"},
      {"min_fit", &O::min_fit, 0, 1, "any mirror image counts"},
      {"point_sigma", &O::point_sigma, 1e-6, 1},
      {"rival_step_m", &O::rival_step_m, 0.1, 100},
      {"max_beside_m", &O::max_beside_m, 0, 100, "no pose beside the vehicle is compared"},
      {"max_ahead_m", &O::max_ahead_m, 0, 100, "no pose ahead and behind is compared"},
  };
  return kFields;
}

absl::Status Validate(const AzimuthSignOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("other_fits", Validate(options.other_fits)));
  return status;
}

AzimuthSigns::AzimuthSigns(std::size_t radar_count, const AzimuthSignOptions& options)
    : options_(options), radars_(radar_count) {
  const auto add = [&](double ahead_m, double beside_m, double turn_rad) {
    T_vehicle_poses_.push_back({.translation_m = {ahead_m, beside_m}, .yaw_rad = turn_rad});
  };
  for (const double turn_rad : {0.0, std::numbers::pi}) {
    add(0.0, 0.0, turn_rad);
    for (int i = 1; i * options.rival_step_m <= options.max_beside_m; ++i) {
      add(0.0, i * options.rival_step_m, turn_rad);
      add(0.0, -i * options.rival_step_m, turn_rad);
    }
  }
  for (int i = 1; i * options.rival_step_m <= options.max_ahead_m; ++i) {
    add(i * options.rival_step_m, 0.0, 0.0);
    add(-i * options.rival_step_m, 0.0, 0.0);
  }
}

bool AzimuthSigns::IsDue(std::size_t index) {
  Radar& radar = radars_[index];
  ++radar.scan_count;
  if (radar.scan_count < options_.scan_interval && radar.is_proven && radar.other_fits.sum() == 0.0)
    return false;
  radar.scan_count = 0;
  return true;
}

// METHOD eq 60.
bool AzimuthSigns::OnFits(std::size_t index, std::size_t point_count, double fit,
                          double mirrored_fit) {
  const double sigma = options_.point_sigma / std::sqrt(static_cast<double>(point_count));
  Radar& radar = radars_[index];
  const double better = mirrored_fit < options_.min_fit ? 0.0 : mirrored_fit - fit;
  radar.other_fits.Add(better / sigma, options_.other_fits);
  if (!radar.other_fits.is_exceeded()) return false;
  radar = {.is_mirrored = !radar.is_mirrored, .is_proven = false};
  return true;
}

void AzimuthSigns::OnConfirmed() {
  for (Radar& radar : radars_) radar.is_proven = true;
}

bool AzimuthSigns::TryOther(std::size_t index) {
  Radar& radar = radars_[index];
  if (radar.is_proven) return false;
  radar = {.is_mirrored = !radar.is_mirrored, .is_proven = false};
  return true;
}

void AzimuthSigns::Reset() {
  for (Radar& radar : radars_) radar.other_fits = {};
}

}  // namespace dcloc
