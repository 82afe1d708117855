#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "client/rosbag/bag_bytes.h"
#include "client/rosbag/bag_reader.h"
#include "client/rosbag/message_types.h"
#include "client/rosbag/message_writer.h"

namespace dcloc::node {

/// At so many milliseconds of the tests' time.
inline Stamp At(std::int64_t time_ms) {
  return Stamp(std::chrono::milliseconds(1'700'000'000'000 + time_ms));
}

/// A message with what it stands in.
struct Sent {
  rosbag::Connection connection;
  std::string data;

  rosbag::Message message() const { return {connection, Stamp{}, data}; }
};

inline Sent Of(const std::string& topic, const rosbag::MessageType& type, std::string data) {
  return {{topic, type.name, type.md5sum}, std::move(data)};
}

/// Targets at 10, 11, ... m straight ahead, of a radar that drives at 20 m/s.
inline Sent CloudAt(Stamp stamp, const std::string& topic = "/front", std::size_t count = 3,
                    const std::string& rate = "range_rate") {
  rosbag::PointCloud cloud{.header = {stamp, "front_radar"},
                           .fields = {{"range", 0, 7, 1}, {"azimuth", 4, 7, 1}, {rate, 8, 7, 1}},
                           .point_count = count,
                           .point_bytes = 12,
                           .data = {}};
  for (std::size_t i = 0; i < count; ++i) {
    rosbag::AppendNumber(cloud.data, 10.0F + static_cast<float>(i));
    rosbag::AppendNumber(cloud.data, 0.0F);
    rosbag::AppendNumber(cloud.data, -20.0F);
  }
  return Of(topic, rosbag::kPointCloud2, rosbag::FormatPointCloud(cloud));
}

inline Sent VelocityAt(Stamp stamp, double speed_mps) {
  EgoVelocity velocity;
  velocity.linear_mps.x() = speed_mps;
  return Of("/velocity", rosbag::kTwistWithCovarianceStamped,
            rosbag::FormatVelocity({stamp, "base_link"}, velocity));
}

inline Sent Mount(const std::string& frame = "front_radar") {
  const Pose3 pose{{3.5, 0.0, 0.5}, Eigen::Quaterniond::Identity()};
  return Of("/tf_static", rosbag::kTf2,
            rosbag::FormatTransforms({{At(0), "base_link", frame, pose}}));
}

inline void AppendHeader(std::string& bytes, Stamp stamp, const std::string& frame) {
  rosbag::AppendNumber(bytes, std::uint32_t{0});
  rosbag::AppendTime(bytes, stamp);
  rosbag::AppendText(bytes, frame);
}

/// nav_msgs/Odometry that has driven so far along x, at that speed.
inline Sent OdometryAt(Stamp stamp, double x_m, double speed_mps) {
  std::string bytes;
  AppendHeader(bytes, stamp, "odom");
  rosbag::AppendText(bytes, "base_link");
  for (const double value : {x_m, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}) {
    rosbag::AppendNumber(bytes, value);
  }
  for (int i = 0; i < 36; ++i) rosbag::AppendNumber(bytes, 0.0);
  for (const double value : {speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0}) {
    rosbag::AppendNumber(bytes, value);
  }
  for (int i = 0; i < 36; ++i) rosbag::AppendNumber(bytes, 0.0);
  return Of("/velocity", rosbag::kOdometry, bytes);
}

/// geometry_msgs/PoseWithCovarianceStamped as RViz sends it.
inline Sent InitialPoseAt(Stamp stamp, double x_m, const std::string& frame = "map") {
  std::string bytes;
  AppendHeader(bytes, stamp, frame);
  for (const double value : {x_m, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}) {
    rosbag::AppendNumber(bytes, value);
  }
  for (int i = 0; i < 36; ++i) {
    rosbag::AppendNumber(bytes, i == 0 || i == 7 ? 0.25 : i == 35 ? 0.07 : 0.0);
  }
  return Of("/initialpose", rosbag::kPoseWithCovarianceStamped, bytes);
}

/// sensor_msgs/NavSatFix.
inline Sent SatelliteFixAt(Stamp stamp, bool has_fix) {
  std::string bytes;
  AppendHeader(bytes, stamp, "gnss");
  rosbag::AppendNumber(bytes, static_cast<std::int8_t>(has_fix ? 0 : -1));
  rosbag::AppendNumber(bytes, std::uint16_t{1});
  for (const double value : {48.1, 11.6, 520.0}) rosbag::AppendNumber(bytes, value);
  for (int i = 0; i < 9; ++i) rosbag::AppendNumber(bytes, 0.0);
  rosbag::AppendNumber(bytes, std::uint8_t{0});
  return Of("/fix", rosbag::kNavSatFix, bytes);
}

}  // namespace dcloc::node
