#include "client/cli/remote/wire.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/remote/learned_rig.h"
#include "client/cli/remote/wire_geometry.h"
#include "core/geometry/covariance.h"
#include "core/geometry/degrees.h"
#include "core/geometry/geodetic_heading.h"

namespace dcloc::cli {
namespace {

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

void Set(v1::GnssFix* message, const GnssFix& fix) {
  Set(message->mutable_position(), fix.position);
  message->set_horizontal_sigma_m(fix.horizontal_sigma_m);
  message->set_vertical_sigma_m(fix.vertical_sigma_m);
  if (!fix.heading_deg) return;
  message->set_heading_deg(*fix.heading_deg);
  message->set_heading_sigma_deg(fix.heading_sigma_deg);
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

// On the wire 0 is "unspecified", and then come core's in their order.
static_assert(static_cast<int>(SourceFault::kNone) + 1 == v1::SOURCE_FAULT_NONE);
static_assert(static_cast<int>(SourceFault::kDelay) + 1 == v1::SOURCE_FAULT_DELAY);

/// Of a SourceHealth or a RadarHealth.
template <typename Message>
void Set(Message* message, const SourceHealth& health) {
  message->set_used(health.is_used);
  message->set_fault(static_cast<v1::SourceFault>(static_cast<int>(health.fault) + 1));
}

template <typename Message>
SourceHealth HealthOf(const Message& message) {
  // A newer server may know more faults.
  const int fault = static_cast<int>(message.fault()) - 1;
  const bool is_known = fault >= 0 && fault < static_cast<int>(kSourceFaultNames.size());
  return {.is_used = message.used(),
          .fault = is_known ? static_cast<SourceFault>(fault) : SourceFault::kSilent};
}

Health HealthOf(const v1::Health& message) {
  Health health{.wheel_speed = HealthOf(message.wheel_speed()),
                .yaw_rate = HealthOf(message.yaw_rate()),
                .radars = {}};
  for (const v1::RadarHealth& radar : message.radars()) health.radars.push_back(HealthOf(radar));
  return health;
}

void Set(v1::Health* message, const Health& health, const Rig& rig) {
  Set(message->mutable_wheel_speed(), health.wheel_speed);
  Set(message->mutable_yaw_rate(), health.yaw_rate);
  for (std::size_t i = 0; i < health.radars.size(); ++i) {
    v1::RadarHealth* radar = message->add_radars();
    radar->set_radar_id(rig.radars.at(i).id);
    Set(radar, health.radars[i]);
  }
}

LocalizationQuality QualityOf(const v1::LocalizationQuality& message) {
  return {.live_point_count = message.live_point_count(),
          .inlier_count = message.inlier_count(),
          .overlap = message.overlap(),
          .residual_scale = message.residual_scale(),
          .normalized_innovation_squared = message.edge_distance(),
          .is_accepted = message.edge_valid(),
          .beta = {.error_s = message.beta_error_s(),
                   .sigma_s = message.beta_error_sigma_s(),
                   .is_wrong = message.beta_is_wrong()}};
}

// On the wire 0 is "unspecified", and then come core's in their order.
constexpr std::array kStates = {LocalizationState::kInitializing, LocalizationState::kTracking,
                                LocalizationState::kDeadReckoning, LocalizationState::kLost};
static_assert(v1::LocalizationState_MAX == static_cast<int>(kStates.size()));
static_assert(v1::LOCALIZATION_STATE_INITIALIZING == 1 && v1::LOCALIZATION_STATE_TRACKING == 2 &&
              v1::LOCALIZATION_STATE_DEAD_RECKONING == 3 && v1::LOCALIZATION_STATE_LOST == 4);

std::optional<LocalizationState> StateOf(v1::LocalizationState state) {
  const int index = static_cast<int>(state) - 1;
  if (index < 0 || index >= static_cast<int>(kStates.size())) return std::nullopt;
  return kStates.at(static_cast<std::size_t>(index));
}

v1::LocalizationState ToProto(LocalizationState state) {
  const auto* const found = std::ranges::find(kStates, state);
  return static_cast<v1::LocalizationState>(found - kStates.begin() + 1);
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

GeodeticAnchor FromProto(const v1::GeodeticAnchor& anchor) {
  return {.origin = PositionOf(anchor.origin()), .x_axis_east_rad = anchor.x_axis_east_rad()};
}

RadarCalibration FromProto(const v1::SurveyedRadar& radar) {
  RadarCalibration calibration;
  calibration.described.id = radar.radar_id();
  calibration.described.beta_s = radar.described_beta_s();
  const auto take = [&](CalibrationParameter parameter, const v1::SurveyedValue& value) {
    calibration.parameters.at(static_cast<std::size_t>(parameter)) = {
        .correction = value.correction(),
        .sigma = value.sigma(),
        .prior_sigma = value.prior_sigma(),
        .applied = value.applied()};
  };
  take(CalibrationParameter::kBeta, radar.beta_s());
  take(CalibrationParameter::kTimeOffset, radar.time_offset_s());
  take(CalibrationParameter::kRangeBias, radar.range_bias_m());
  take(CalibrationParameter::kMountYaw, radar.mount_yaw_rad());
  return calibration;
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
  for (const MotionTick& tick : scan.ticks) {
    v1::MotionTicks& motion = *message.mutable_motion();
    motion.add_stamp_offset_ns(tick.after_scan.count());
    motion.add_speed_mps(static_cast<float>(tick.speed_mps));
    motion.add_yaw_rate_radps(static_cast<float>(tick.yaw_rate_radps));
  }
  if (!scan.ego_velocity) return message;
  v1::EgoVelocity& ego_velocity = *message.mutable_ego_velocity();
  Set(ego_velocity.mutable_linear_mps(), scan.ego_velocity->linear_mps);
  Set(ego_velocity.mutable_angular_radps(), scan.ego_velocity->angular_radps);
  if (scan.ego_velocity->covariance) {
    Set(ego_velocity.mutable_covariance(), *scan.ego_velocity->covariance);
  }
  return message;
}

v1::PositionFix ToProto(const StampedFix& fix) {
  v1::PositionFix message;
  message.set_stamp_ns(fix.stamp.time_since_epoch().count());
  if (const auto* gnss = std::get_if<GnssFix>(&fix.position)) {
    Set(message.mutable_gnss_fix(), *gnss);
  } else {
    *message.mutable_map_pose() = ToProto(PoseOf(std::get<MapFix>(fix.position)));
  }
  return message;
}

v1::FixUse ToProto(FixUse use) {
  switch (use) {
    case FixUse::kFused:
    case FixUse::kConsistentNotFused:  // the contract has one value for both
      return v1::FIX_USE_FUSED;
    case FixUse::kGuidesSearch:
      return v1::FIX_USE_GUIDES_SEARCH;
    case FixUse::kContradicted:
      return v1::FIX_USE_CONTRADICTED;
    case FixUse::kOutOfTime:
      return v1::FIX_USE_OUT_OF_TIME;
  }
  return v1::FIX_USE_UNSPECIFIED;
}

v1::LocalizationResult ToProto(const Localization& localization, const Rig& rig,
                               std::int64_t sequence_number) {
  v1::LocalizationResult message;
  message.set_sequence_number(sequence_number);
  message.set_stamp_ns(localization.stamp.time_since_epoch().count());
  message.set_state(ToProto(localization.state));
  *message.mutable_pose() = ToProto(InitialPose{.T_map_vehicle = localization.T_map_vehicle,
                                                .covariance = localization.covariance});
  message.set_observed_dof_mask(static_cast<std::int32_t>(localization.observed.to_ulong()));
  if (localization.protection_level_m) {
    message.set_protection_level_m(*localization.protection_level_m);
  }
  Set(message.mutable_health(), localization.health, rig);
  const PoseResets& resets = localization.resets;
  message.mutable_resets()->set_count(resets.count);
  if (resets.count > 0) Set(message.mutable_resets()->mutable_last_jump(), resets.T_before_after);
  v1::LocalizationQuality& quality = *message.mutable_quality();
  quality.set_live_point_count(localization.quality.live_point_count);
  quality.set_inlier_count(localization.quality.inlier_count);
  quality.set_overlap(localization.quality.overlap);
  quality.set_residual_scale(localization.quality.residual_scale);
  quality.set_edge_distance(localization.quality.normalized_innovation_squared);
  quality.set_edge_valid(localization.quality.is_accepted);
  quality.set_beta_error_s(localization.quality.beta.error_s);
  quality.set_beta_error_sigma_s(localization.quality.beta.sigma_s);
  quality.set_beta_is_wrong(localization.quality.beta.is_wrong);
  if (localization.learned) *message.mutable_learned_rig() = ToProto(*localization.learned);
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
  answer.T_map_vehicle = PoseOf(result.pose().pose());
  answer.covariance = TangentFromFixedAxes(answer.T_map_vehicle,
                                           RowMajor6d::Map(result.pose().covariance().data()));
  answer.observed = static_cast<unsigned long>(result.observed_dof_mask());
  if (result.has_protection_level_m()) answer.protection_level_m = result.protection_level_m();
  answer.health = HealthOf(result.health());
  answer.resets.count = static_cast<int>(result.resets().count());
  if (result.resets().has_last_jump()) {
    answer.resets.T_before_after = PoseOf(result.resets().last_jump());
  }
  answer.quality = QualityOf(result.quality());
  if (result.has_learned_rig()) answer.learned = FromProto(result.learned_rig());
  return answer;
}

}  // namespace dcloc::cli
