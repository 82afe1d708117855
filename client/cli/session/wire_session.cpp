#include "client/cli/session/wire_session.h"

#include <vector>

#include "client/cli/remote/learned_rig.h"
#include "client/cli/remote/wire_geometry.h"
#include "core/geometry/covariance.h"
#include "core/relocalization/gnss_prior.h"

namespace dcloc::cli {
namespace {

/// As the server does.
Pose3 NormalizedPoseOf(const v1::Pose& message) {
  Pose3 pose = PoseOf(message);
  pose.rotation.normalize();
  return pose;
}

RadarModel RadarFromProto(const v1::RadarModel& message) {
  RadarModel radar;
  radar.id = message.radar_id();
  radar.T_vehicle_radar = NormalizedPoseOf(message.t_vehicle_radar());
  if (message.has_beta_s()) radar.beta_s = message.beta_s();
  if (message.has_chirp()) {
    radar.beta_s =
        BetaFromChirp(message.chirp().centre_frequency_hz(), message.chirp().slope_hz_per_s());
  }
  if (message.has_range_sigma_m()) radar.range_sigma_m = message.range_sigma_m();
  if (message.has_range_rate_sigma_mps()) {
    radar.range_rate_sigma_mps = message.range_rate_sigma_mps();
  }
  if (message.has_azimuth_sigma_rad()) radar.azimuth_sigma_rad = message.azimuth_sigma_rad();
  if (message.has_elevation_sigma_rad()) radar.elevation_sigma_rad = message.elevation_sigma_rad();
  if (message.has_beta_sigma_s()) radar.beta_sigma_s = message.beta_sigma_s();
  if (message.has_range_bias_sigma_m()) radar.range_bias_sigma_m = message.range_bias_sigma_m();
  if (message.has_time_offset_sigma_s()) {
    radar.time_offset_sigma_s = message.time_offset_sigma_s();
  }
  if (message.has_mount_yaw_sigma_rad()) {
    radar.mount_yaw_sigma_rad = message.mount_yaw_sigma_rad();
  }
  radar.has_elevation = message.has_elevation();
  radar.unambiguous_range_rate_mps = message.unambiguous_range_rate_mps();
  radar.range_bias_m = message.range_bias_m();
  radar.time_offset_s = message.time_offset_s();
  return radar;
}

LocalizerOptions OptionsOf(const v1::LocalizationOptions& message) {
  LocalizerOptions options;
  if (message.has_scans_per_submap()) options.scans_per_submap = message.scans_per_submap();
  if (message.has_doppler_compensation()) {
    options.doppler_compensation = message.doppler_compensation();
  }
  if (message.has_uncertainty()) options.per_point_covariance = message.uncertainty();
  if (message.has_truncation()) options.gate_outliers = message.truncation();
  return options;
}

GnssFix FixOf(const v1::GnssFix& message) {
  GnssFix fix{.position = PositionOf(message.position()),
              .horizontal_sigma_m = message.horizontal_sigma_m(),
              .vertical_sigma_m = message.vertical_sigma_m(),
              .heading_deg = {},
              .heading_sigma_deg = message.heading_sigma_deg()};
  if (message.has_heading_deg()) fix.heading_deg = message.heading_deg();
  return fix;
}

absl::StatusOr<InitialPose> PoseOf(const v1::PoseWithCovariance& message) {
  if (message.covariance_size() != RowMajor6d::SizeAtCompileTime) {
    return absl::DataLossError("a recorded pose has no covariance of 36 values");
  }
  const Pose3 T_map_vehicle = NormalizedPoseOf(message.pose());
  return InitialPose{.T_map_vehicle = T_map_vehicle,
                     .covariance = TangentFromFixedAxes(
                         T_map_vehicle, RowMajor6d::Map(message.covariance().data()))};
}

std::vector<float> ColumnOf(const google::protobuf::RepeatedField<float>& values) {
  return {values.begin(), values.end()};
}

}  // namespace

absl::StatusOr<SessionStart> FromProto(const v1::OpenSession& open,
                                       const std::optional<GeodeticAnchor>& anchor) {
  SessionStart start;
  for (const v1::RadarModel& radar : open.rig().radars()) {
    start.rig.radars.push_back(RadarFromProto(radar));
  }
  start.options = OptionsOf(open.options());
  if (open.has_learned_rig()) start.options.known = FromProto(open.learned_rig());
  if (open.has_gnss_fix()) {
    if (!anchor) {
      return absl::FailedPreconditionError(
          "the session began with a GNSS fix, and the map has no anchor on the Earth");
    }
    start.initial_pose = PriorFromGnss(FixOf(open.gnss_fix()), *anchor);
  } else if (open.has_initial_pose()) {
    const absl::StatusOr<InitialPose> pose = PoseOf(open.initial_pose());
    if (!pose.ok()) return pose.status();
    start.initial_pose = *pose;
  }
  return start;
}

absl::StatusOr<PositionFix> FromProto(const v1::PositionFix& message,
                                      const std::optional<GeodeticAnchor>& anchor) {
  PositionFix fix{.stamp = Stamp(std::chrono::nanoseconds(message.stamp_ns())), .pose = {}};
  if (message.has_gnss_fix()) {
    if (!anchor) {
      return absl::FailedPreconditionError(
          "the session has GNSS fixes, and the map has no anchor on the Earth");
    }
    fix.pose = PriorFromGnss(FixOf(message.gnss_fix()), *anchor);
    return fix;
  }
  const absl::StatusOr<InitialPose> pose = PoseOf(message.map_pose());
  if (!pose.ok()) return pose.status();
  fix.pose = *pose;
  return fix;
}

Scan FromProto(const v1::Scan& message) {
  Scan scan;
  scan.stamp = Stamp(std::chrono::nanoseconds(message.stamp_ns()));
  scan.radar_id = message.radar_id();
  scan.range_m = ColumnOf(message.range_m());
  scan.range_rate_mps = ColumnOf(message.range_rate_mps());
  scan.azimuth_rad = ColumnOf(message.azimuth_rad());
  scan.elevation_rad = ColumnOf(message.elevation_rad());
  scan.rcs_dbsm = ColumnOf(message.rcs_dbsm());
  scan.range_sigma_m = ColumnOf(message.range_sigma_m());
  scan.range_rate_sigma_mps = ColumnOf(message.range_rate_sigma_mps());
  scan.azimuth_sigma_rad = ColumnOf(message.azimuth_sigma_rad());
  scan.elevation_sigma_rad = ColumnOf(message.elevation_sigma_rad());
  const v1::MotionTicks& motion = message.motion();
  for (int i = 0; i < motion.stamp_offset_ns_size(); ++i) {
    scan.ticks.push_back({.after_scan = std::chrono::nanoseconds(motion.stamp_offset_ns(i)),
                          .speed_mps = motion.speed_mps(i),
                          .yaw_rate_radps = motion.yaw_rate_radps(i)});
  }
  if (!message.has_ego_velocity()) return scan;
  const v1::EgoVelocity& ego_velocity = message.ego_velocity();
  scan.ego_velocity = EgoVelocity{.linear_mps = VectorOf(ego_velocity.linear_mps()),
                                  .angular_radps = VectorOf(ego_velocity.angular_radps()),
                                  .covariance = {}};
  if (ego_velocity.covariance_size() == RowMajor6d::SizeAtCompileTime) {
    scan.ego_velocity->covariance = RowMajor6d::Map(ego_velocity.covariance().data());
  }
  return scan;
}

}  // namespace dcloc::cli
