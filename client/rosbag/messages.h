#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/pose.h"
#include "core/radar/ego_velocity.h"
#include "core/radar/stamp.h"

namespace dcloc::rosbag {

// Messages of ROS as far as they are used here. Units are those of REP 103: SI, radians.

struct Header {
  Stamp stamp;
  std::string frame_id;  ///< without the slash that old programs write before it
};

/// A column of a point cloud.
struct PointField {
  std::string name;
  std::uint32_t offset = 0;  ///< bytes within a point
  std::uint8_t datatype = 0;
  std::uint32_t count = 1;
};

/// sensor_msgs/PointCloud2 with its rows joined.
struct PointCloud {
  Header header;
  std::vector<PointField> fields;
  std::size_t point_count = 0;
  std::size_t point_bytes = 0;
  std::string data;  ///< point_count * point_bytes, little-endian

  const PointField* Find(const std::string& name) const;
  /// Of a field of `fields`, as a number whatever its type.
  double Value(const PointField& field, std::size_t point) const;
};

/// A frame in another, from TF.
struct Transform {
  Stamp stamp;
  std::string parent;
  std::string child;
  Pose3 T_parent_child;
};

/// nav_msgs/Odometry and geometry_msgs/Twist*Stamped, Pose*Stamped: what each has of these.
struct Motion {
  Header header;
  std::string child_frame;  ///< the velocity's, and whose pose it is; may be empty
  std::optional<Pose3> T_frame_child;
  /// Of (x, y, z, rotation about x, y, z) along and about the frame's axes; absent where the type
  /// has none, or it is zero.
  std::optional<Matrix6d> pose_covariance;
  std::optional<EgoVelocity> velocity;
};

/// sensor_msgs/Imu without what is not used.
struct ImuSample {
  Header header;
  Eigen::Vector3d angular_radps = Eigen::Vector3d::Zero();
};

/// diagnostic_msgs/DiagnosticStatus.
struct Diagnostic {
  enum class Level : std::int8_t { kOk = 0, kWarn = 1, kError = 2 };
  Level level = Level::kOk;
  std::string name;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};

/// sensor_msgs/NavSatFix.
struct SatelliteFix {
  Header header;
  bool has_fix = false;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double height_m = 0.0;
  std::optional<double> horizontal_sigma_m;  ///< absent where the receiver does not say
  std::optional<double> vertical_sigma_m;
};

}  // namespace dcloc::rosbag
