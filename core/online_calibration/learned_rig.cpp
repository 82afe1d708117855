#include "core/online_calibration/learned_rig.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dcloc {

std::span<const OptionField<LearnedRigOptions>> FieldsOf(const LearnedRigOptions& /*options*/) {
  using O = LearnedRigOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_correction_rad", &O::min_correction_rad, 0, 3.2, "every mount is corrected"},
      {"correction_sigmas", &O::correction_sigmas, 0, 1000, "a single reading corrects"},
      {"min_reading_count", &O::min_reading_count, 1, 10'000},
      {"known_sigma_rad", &O::known_sigma_rad, 1e-9, 1},
      {"corrected_sigma_rad", &O::corrected_sigma_rad, 1e-9, 1},
      {"suspected_rad", &O::suspected_rad, 1e-9, 3.2},
      {"max_correction_rad", &O::max_correction_rad, 0, 3.2, "no mount is corrected"},
      {"suspected_range_m", &O::suspected_range_m, 1e-9, 100},
  };
  return kFields;
}

absl::Status Validate(const LearnedRigOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("mount_yaw", Validate(options.mount_yaw)));
  status.Update(Within("stamps", Validate(options.stamps)));
  return status;
}

LearnedRig::LearnedRig(Rig described, const LearnedRigOptions& options)
    : options_(options),
      described_(std::move(described)),
      rig_(described_),
      stamps_(described_, options.stamps) {
  for (const RadarModel& radar : described_.radars) {
    learned_.push_back({.mount_yaw = {radar.mount_yaw_sigma_rad, options.mount_yaw}});
  }
}

void LearnedRig::Restore(const RigKnowledge& known) {
  stamps_.Restore(known);
  ApplyStamps();
  for (std::size_t i = 0; i < learned_.size(); ++i) {
    const RadarKnowledge* radar = known.Find(described_.radars[i].id);
    if (radar == nullptr || !radar->mount_yaw_error) continue;
    const ScalarEstimate& error = *radar->mount_yaw_error;
    learned_[i].mount_yaw.Restore(
        {error.value, std::max(error.variance, std::pow(options_.known_sigma_rad, 2))},
        options_.min_reading_count - 1);
  }
}

void LearnedRig::AddTo(RigKnowledge& known) const {
  stamps_.AddTo(known);
  for (std::size_t i = 0; i < learned_.size(); ++i) {
    const MountYawEstimator& mount_yaw = learned_[i].mount_yaw;
    if (mount_yaw.reading_count() < options_.min_reading_count) continue;
    const double variance =
        std::max(mount_yaw.error().variance, std::pow(options_.corrected_sigma_rad, 2));
    known.Of(described_.radars[i].id).mount_yaw_error = {mount_yaw.error().value, variance};
  }
}

bool LearnedRig::OnScan(Stamp stamp, std::size_t index, const Scan& scan,
                        const EgoVelocity& velocity) {
  Learned& learned = learned_[index];
  return learned.mount_yaw.OnScan(stamp, scan, described_.radars[index], velocity, workspace_) &&
         Correct(index);
}

void LearnedRig::BeginToLearnStamps(double map_delay_s) {
  stamps_.Begin(map_delay_s);
  ApplyStamps();
}

double LearnedRig::LearnStamps(Stamp stamp, std::size_t index, const Scan& scan, bool is_sound) {
  const double change_s = stamps_.OnScan(stamp, index, scan, is_sound);
  ApplyStamps();
  return change_s;
}

void LearnedRig::ApplyStamps() {
  for (std::size_t i = 0; i < rig_.radars.size(); ++i) {
    RadarModel& radar = rig_.radars[i];
    const std::optional<ScalarEstimate>& corrected = stamps_.time_offset_s(i);
    radar.time_offset_s = corrected ? corrected->value : described_.radars[i].time_offset_s;
    radar.time_offset_sigma_s =
        corrected ? std::sqrt(corrected->variance) : described_.radars[i].time_offset_sigma_s;
  }
}

bool LearnedRig::Correct(std::size_t index) {
  Learned& learned = learned_[index];
  const ScalarEstimate& error = learned.mount_yaw.error();
  const double needed_rad =
      std::max(options_.min_correction_rad, options_.correction_sigmas * std::sqrt(error.variance));
  if (learned.mount_yaw.reading_count() < options_.min_reading_count ||
      std::abs(error.value - learned.applied_rad) < needed_rad) {
    return false;
  }
  learned.applied_rad = error.value;
  RadarModel& radar = rig_.radars[index];
  radar.T_vehicle_radar.rotation = Eigen::AngleAxisd(error.value, Eigen::Vector3d::UnitZ()) *
                                   described_.radars[index].T_vehicle_radar.rotation;
  radar.mount_yaw_sigma_rad = std::max({options_.corrected_sigma_rad, std::sqrt(error.variance),
                                        described_.radars[index].mount_yaw_sigma_rad});
  return true;
}

void LearnedRig::CorrectRange(std::size_t index,
                              const std::optional<ScalarEstimate>& bias_error_m) {
  const RadarModel& described = described_.radars[index];
  const ScalarEstimate error_m = bias_error_m.value_or(ScalarEstimate{});
  RadarModel& radar = rig_.radars[index];
  radar.range_bias_m = described.range_bias_m + error_m.value;
  radar.range_bias_sigma_m = std::max(described.range_bias_sigma_m, std::sqrt(error_m.variance));
}

SourceFault LearnedRig::FaultOf(std::size_t index, Stamp stamp) const {
  const double range_error_m =
      rig_.radars[index].range_bias_m - described_.radars[index].range_bias_m;
  const bool is_suspected = !IsUsable(index, stamp) ||
                            std::abs(learned_[index].applied_rad) > options_.suspected_rad ||
                            std::abs(range_error_m) > options_.suspected_range_m;
  return is_suspected ? SourceFault::kMount : SourceFault::kNone;
}

bool LearnedRig::IsUsable(std::size_t index, Stamp stamp) const {
  const Learned& learned = learned_[index];
  return std::abs(learned.applied_rad) <= options_.max_correction_rad &&
         !learned.mount_yaw.HasRecentOutliers(stamp);
}

}  // namespace dcloc
