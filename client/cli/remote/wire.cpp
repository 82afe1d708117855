#include "client/cli/remote/wire.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/geometry/covariance.h"
#include "core/geometry/degrees.h"
#include "core/geometry/geodetic_heading.h"

namespace dcloc::cli {
namespace {

using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

void Set(v1::Vector3* message, const Eigen::Vector3d& vector) {
  message->set_x(vector.x());
  message->set_y(vector.y());
  message->set_z(vector.z());
}

void Set(v1::GeodeticPosition* message, const GeodeticPosition& position) {
  message->set_latitude_deg(position.latitude_deg);
  message->set_longitude_deg(position.longitude_deg);
  message->set_height_m(position.height_m);
}

void Set(v1::Pose* message, const Pose3& pose) {
  Set(message->mutable_translation_m(), pose.translation_m);
  message->mutable_rotation()->set_w(pose.rotation.w());
  message->mutable_rotation()->set_x(pose.rotation.x());
  message->mutable_rotation()->set_y(pose.rotation.y());
  message->mutable_rotation()->set_z(pose.rotation.z());
}

void Set(google::protobuf::RepeatedField<double>* message, const RowMajor6d& covariance) {
  message->Assign(covariance.data(), covariance.data() + covariance.size());
}

void Set(google::protobuf::RepeatedField<float>* message, const std::vector<float>& column) {
  message->Assign(column.begin(), column.end());
}

Eigen::Quaterniond RotationOf(const v1::Quaternion& message) {
  return {message.w(), message.x(), message.y(), message.z()};
}

LocalizationQuality QualityOf(const v1::LocalizationQuality& message) {
  return {.live_point_count = message.live_point_count(),
          .inlier_count = message.inlier_count(),
          .overlap = message.overlap(),
          .residual_scale = message.residual_scale(),
          .edge_distance = message.edge_distance(),
          .edge_valid = message.edge_valid(),
          .beta = {.error_s = message.beta_error_s(),
                   .sigma_s = message.beta_error_sigma_s(),
                   .is_wrong = message.beta_is_wrong()}};
}

std::optional<LocalizationState> StateOf(v1::LocalizationState state) {
  switch (state) {
    case v1::LOCALIZATION_STATE_INITIALIZING:
      return LocalizationState::kInitializing;
    case v1::LOCALIZATION_STATE_TRACKING:
      return LocalizationState::kTracking;
    case v1::LOCALIZATION_STATE_DEAD_RECKONING:
      return LocalizationState::kDeadReckoning;
    case v1::LOCALIZATION_STATE_LOST:
      return LocalizationState::kLost;
    default:
      return std::nullopt;
  }
}

v1::LocalizationState ToProto(LocalizationState state) {
  switch (state) {
    case LocalizationState::kInitializing:
      return v1::LOCALIZATION_STATE_INITIALIZING;
    case LocalizationState::kTracking:
      return v1::LOCALIZATION_STATE_TRACKING;
    case LocalizationState::kDeadReckoning:
      return v1::LOCALIZATION_STATE_DEAD_RECKONING;
    case LocalizationState::kLost:
      return v1::LOCALIZATION_STATE_LOST;
  }
  return v1::LOCALIZATION_STATE_UNSPECIFIED;
}

}  // namespace

v1::Rig ToProto(const Rig& rig) {
  v1::Rig message;
  for (const RadarModel& radar : rig.radars) {
    v1::RadarModel& added = *message.add_radars();
    added.set_radar_id(radar.id);
    Set(added.mutable_t_vehicle_radar(), radar.T_vehicle_radar);
    added.set_beta_s(radar.beta_s);
    added.set_range_sigma_m(radar.range_sigma_m);
    added.set_range_rate_sigma_mps(radar.range_rate_sigma_mps);
    added.set_azimuth_sigma_rad(radar.azimuth_sigma_rad);
    added.set_elevation_sigma_rad(radar.elevation_sigma_rad);
    added.set_has_elevation(radar.has_elevation);
    added.set_unambiguous_range_rate_mps(radar.unambiguous_range_rate_mps);
    added.set_range_bias_m(radar.range_bias_m);
    added.set_time_offset_s(radar.time_offset_s);
    added.set_beta_sigma_s(radar.beta_sigma_s);
    added.set_range_bias_sigma_m(radar.range_bias_sigma_m);
    added.set_time_offset_sigma_s(radar.time_offset_sigma_s);
    added.set_mount_yaw_sigma_rad(radar.mount_yaw_sigma_rad);
  }
  return message;
}

v1::PoseWithCovariance ToProto(const InitialPose& initial_pose) {
  v1::PoseWithCovariance message;
  Set(message.mutable_pose(), initial_pose.T_map_vehicle);
  Set(message.mutable_covariance(),
      FixedAxesFromTangent(initial_pose.T_map_vehicle, initial_pose.covariance));
  return message;
}

v1::GeodeticAnchor ToProto(const GeodeticAnchor& anchor) {
  v1::GeodeticAnchor message;
  Set(message.mutable_origin(), anchor.origin);
  message.set_x_axis_east_rad(anchor.x_axis_east_rad);
  return message;
}

v1::GnssFix FixOf(const InitialPose& pose, const GeodeticAnchor& anchor) {
  const Vector6d variances = pose.covariance.diagonal();
  v1::GnssFix message;
  Set(message.mutable_position(), GeodeticFromMap(anchor, pose.T_map_vehicle.translation_m));
  message.set_horizontal_sigma_m(std::sqrt(std::max(variances[0], variances[1])));
  message.set_vertical_sigma_m(std::sqrt(variances[2]));
  message.set_heading_deg(HeadingFromMap(anchor, pose.T_map_vehicle));
  message.set_heading_sigma_deg(std::sqrt(variances[5]) * kDegPerRad);
  return message;
}

v1::Scan ToProto(const Scan& scan, std::int64_t sequence_number) {
  v1::Scan message;
  message.set_sequence_number(sequence_number);
  message.set_radar_id(scan.radar_id);
  message.set_stamp_ns(scan.stamp.time_since_epoch().count());
  Set(message.mutable_range_m(), scan.range_m);
  Set(message.mutable_range_rate_mps(), scan.range_rate_mps);
  Set(message.mutable_azimuth_rad(), scan.azimuth_rad);
  Set(message.mutable_elevation_rad(), scan.elevation_rad);
  Set(message.mutable_rcs_dbsm(), scan.rcs_dbsm);
  Set(message.mutable_range_sigma_m(), scan.range_sigma_m);
  Set(message.mutable_range_rate_sigma_mps(), scan.range_rate_sigma_mps);
  Set(message.mutable_azimuth_sigma_rad(), scan.azimuth_sigma_rad);
  Set(message.mutable_elevation_sigma_rad(), scan.elevation_sigma_rad);
  if (!scan.ego_velocity) return message;
  v1::EgoVelocity& ego_velocity = *message.mutable_ego_velocity();
  Set(ego_velocity.mutable_linear_mps(), scan.ego_velocity->linear_mps);
  Set(ego_velocity.mutable_angular_radps(), scan.ego_velocity->angular_radps);
  if (scan.ego_velocity->covariance) {
    Set(ego_velocity.mutable_covariance(), *scan.ego_velocity->covariance);
  }
  return message;
}

v1::LocalizationResult ToProto(const Localization& localization, std::int64_t sequence_number) {
  v1::LocalizationResult message;
  message.set_sequence_number(sequence_number);
  message.set_stamp_ns(localization.stamp.time_since_epoch().count());
  message.set_state(ToProto(localization.state));
  *message.mutable_pose() = ToProto(InitialPose{.T_map_vehicle = localization.T_map_vehicle,
                                                .covariance = localization.covariance});
  message.set_observed_dof_mask(static_cast<std::int32_t>(localization.observed.to_ulong()));
  v1::LocalizationQuality& quality = *message.mutable_quality();
  quality.set_live_point_count(localization.quality.live_point_count);
  quality.set_inlier_count(localization.quality.inlier_count);
  quality.set_overlap(localization.quality.overlap);
  quality.set_residual_scale(localization.quality.residual_scale);
  quality.set_edge_distance(localization.quality.edge_distance);
  quality.set_edge_valid(localization.quality.edge_valid);
  quality.set_beta_error_s(localization.quality.beta.error_s);
  quality.set_beta_error_sigma_s(localization.quality.beta.sigma_s);
  quality.set_beta_is_wrong(localization.quality.beta.is_wrong);
  return message;
}

absl::StatusOr<Localization> FromProto(const v1::LocalizationResult& result) {
  const std::optional<LocalizationState> state = StateOf(result.state());
  if (!state) {
    return absl::DataLossError(absl::StrCat("the server's state is ", result.state()));
  }
  if (result.pose().covariance_size() != RowMajor6d::SizeAtCompileTime) {
    return absl::DataLossError(absl::StrCat("the server's covariance has ",
                                            result.pose().covariance_size(), " values, not 36"));
  }
  Localization answer;
  answer.stamp = Stamp(std::chrono::nanoseconds(result.stamp_ns()));
  answer.state = *state;
  const v1::Vector3& t = result.pose().pose().translation_m();
  answer.T_map_vehicle = {.translation_m = {t.x(), t.y(), t.z()},
                          .rotation = RotationOf(result.pose().pose().rotation())};
  answer.covariance = TangentFromFixedAxes(answer.T_map_vehicle,
                                           RowMajor6d::Map(result.pose().covariance().data()));
  answer.observed = static_cast<unsigned long>(result.observed_dof_mask());
  answer.quality = QualityOf(result.quality());
  return answer;
}

}  // namespace dcloc::cli
