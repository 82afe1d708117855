#include "core/odometry/learned_rig.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/radar/measurement.h"

namespace dcloc {
namespace {

// The direction in which the radar moves, counter-clockwise from its boresight.
double DirectionOfMotion(const RadarModel& radar, const EgoVelocity& velocity) {
  const Eigen::Vector3d radar_mps =
      velocity.linear_mps + velocity.angular_radps.cross(radar.T_vehicle_radar.translation_m);
  const Eigen::Vector3d in_radar = radar.T_vehicle_radar.Rotation().transpose() * radar_mps;
  return std::atan2(in_radar.y(), in_radar.x());
}

// The fraction of the targets that stand still, if azimuths are counted so.
double StaticFraction(const Scan& scan, const RadarModel& radar, const EgoVelocity& velocity,
                      double azimuth_sign, double gate_mps) {
  int count = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Measurement m = MeasurementAt(scan, i, radar);
    const Eigen::Vector3d u = radar.T_vehicle_radar.Rotation() *
                              LineOfSight(azimuth_sign * m.azimuth_rad, m.elevation_rad);
    const double predicted_mps = PredictedRangeRate(u, radar.T_vehicle_radar, velocity);
    const double range_rate_mps =
        UnfoldRangeRate(m.range_rate_mps, predicted_mps, radar.unambiguous_range_rate_mps);
    if (std::abs(range_rate_mps - predicted_mps) <= gate_mps) ++count;
  }
  return static_cast<double>(count) / static_cast<double>(scan.size());
}

}  // namespace

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
      {"mirrored_min_angle_rad", &O::mirrored_min_angle_rad, 1e-6, 3.2},
      {"mirrored_fraction", &O::mirrored_fraction, 0.01, 1},
      {"mirrored_forgetting_factor", &O::mirrored_forgetting_factor, 0, 0.999,
       "each scan stands alone"},
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
  CheckMirrored(learned, rig_.radars[index], scan, velocity);
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

// Azimuths of the other sign explain more of the range rates.
void LearnedRig::CheckMirrored(Learned& learned, const RadarModel& radar, const Scan& scan,
                               const EgoVelocity& velocity) const {
  if (scan.size() == 0 || velocity.linear_mps.head<2>().norm() < options_.mount_yaw.min_speed_mps ||
      std::abs(DirectionOfMotion(radar, velocity)) < options_.mirrored_min_angle_rad) {
    return;
  }
  const double gate_mps = options_.mount_yaw.inlier_gate_mps;
  const double advantage = StaticFraction(scan, radar, velocity, -1.0, gate_mps) -
                           StaticFraction(scan, radar, velocity, 1.0, gate_mps);
  learned.mirrored_fraction = options_.mirrored_forgetting_factor * learned.mirrored_fraction +
                              (1.0 - options_.mirrored_forgetting_factor) * advantage;
}

void LearnedRig::OnRegistered() {
  for (Learned& learned : learned_) learned.mirrored_fraction = 0.0;
}

SourceFault LearnedRig::FaultOf(std::size_t index, Stamp stamp) const {
  const bool is_suspected =
      !IsUsable(index, stamp) || std::abs(learned_[index].applied_rad) > options_.suspected_rad;
  return is_suspected ? SourceFault::kMount : SourceFault::kNone;
}

bool LearnedRig::IsUsable(std::size_t index, Stamp stamp) const {
  const Learned& learned = learned_[index];
  return learned.mirrored_fraction < options_.mirrored_fraction &&
         std::abs(learned.applied_rad) <= options_.max_correction_rad &&
         !learned.mount_yaw.HasRecentOutliers(stamp);
}

}  // namespace dcloc
