#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "dcloc/v1/localization_service.pb.h"
#include "dcloc/v1/scan.pb.h"
#include "server/maps/sha256.h"

/// Messages as a well-behaved vehicle sends them, for tests to send as they are or to spoil.
namespace dcloc::server {

inline v1::Pose IdentityPose() {
  v1::Pose pose;
  pose.mutable_translation_m();
  pose.mutable_rotation()->set_w(1.0);
  return pose;
}

inline v1::RadarModel RadarMessage(const std::string& radar_id) {
  v1::RadarModel radar;
  radar.set_radar_id(radar_id);
  *radar.mutable_t_vehicle_radar() = IdentityPose();
  return radar;
}

/// Variances of 1 m^2 and 0.01 rad^2.
inline v1::PoseWithCovariance InitialPoseMessage() {
  v1::PoseWithCovariance message;
  *message.mutable_pose() = IdentityPose();
  for (int i = 0; i < 36; ++i) {
    const bool diagonal = i % 7 == 0;
    message.add_covariance(!diagonal ? 0.0 : i < 18 ? 1.0 : 0.01);
  }
  return message;
}

/// Opens a session of one radar, "front", in map "town".
inline v1::OpenSession OpenMessage() {
  v1::OpenSession open;
  open.set_vehicle_id("car-1");
  open.set_map_name("town");
  *open.mutable_rig()->add_radars() = RadarMessage("front");
  *open.mutable_initial_pose() = InitialPoseMessage();
  return open;
}

/// A scan of "front", 77 ms after the one before, of a vehicle that drives ahead at 10 m/s.
inline v1::Scan ScanMessage(std::int64_t sequence_number, int target_count = 20) {
  v1::Scan scan;
  scan.set_sequence_number(sequence_number);
  scan.set_radar_id("front");
  scan.set_stamp_ns(1'700'000'000'000'000'000 + sequence_number * 77'000'000);
  for (int i = 0; i < target_count; ++i) {
    const float azimuth_rad =
        -0.6F + 1.2F * static_cast<float>(i) / static_cast<float>(target_count);
    scan.add_range_m(5.0F + static_cast<float>(i % 60));
    scan.add_range_rate_mps(-10.0F * std::cos(azimuth_rad));
    scan.add_azimuth_rad(azimuth_rad);
    scan.add_rcs_dbsm(3.0F);
  }
  scan.mutable_ego_velocity()->mutable_linear_mps()->set_x(10.0);
  scan.mutable_ego_velocity()->mutable_angular_radps();
  return scan;
}

inline void SetColumn(const std::vector<float>& values,
                      google::protobuf::RepeatedField<float>* column) {
  column->Assign(values.begin(), values.end());
}

/// A core scan on the wire.
inline v1::Scan MessageOf(const Scan& scan, std::int64_t sequence_number) {
  v1::Scan message;
  message.set_sequence_number(sequence_number);
  message.set_radar_id(scan.radar_id);
  message.set_stamp_ns(scan.stamp.time_since_epoch().count());
  SetColumn(scan.range_m, message.mutable_range_m());
  SetColumn(scan.range_rate_mps, message.mutable_range_rate_mps());
  SetColumn(scan.azimuth_rad, message.mutable_azimuth_rad());
  SetColumn(scan.elevation_rad, message.mutable_elevation_rad());
  SetColumn(scan.rcs_dbsm, message.mutable_rcs_dbsm());
  if (scan.ego_velocity) {
    v1::EgoVelocity* ego_velocity = message.mutable_ego_velocity();
    ego_velocity->mutable_linear_mps()->set_x(scan.ego_velocity->linear_mps.x());
    ego_velocity->mutable_linear_mps()->set_y(scan.ego_velocity->linear_mps.y());
    ego_velocity->mutable_linear_mps()->set_z(scan.ego_velocity->linear_mps.z());
    ego_velocity->mutable_angular_radps()->set_x(scan.ego_velocity->angular_radps.x());
    ego_velocity->mutable_angular_radps()->set_y(scan.ego_velocity->angular_radps.y());
    ego_velocity->mutable_angular_radps()->set_z(scan.ego_velocity->angular_radps.z());
  }
  return message;
}

inline std::string Sha256Of(std::span<const std::byte> bytes) {
  Sha256 hash;
  hash.Update(bytes);
  return hash.Finish();
}

}  // namespace dcloc::server
