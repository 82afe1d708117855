#pragma once

#include <span>
#include <string>

#include "absl/strings/string_view.h"

namespace dcloc::rosbag {

/// A type of ROS messages whose layout we know.
struct MessageType {
  const char* name;    ///< "nav_msgs/Odometry"
  const char* md5sum;  ///< of its definition; another one is another layout
};

inline constexpr MessageType kPointCloud2{"sensor_msgs/PointCloud2",
                                          "1158d486dd51d683ce2f1be655c3c181"};
inline constexpr MessageType kOdometry{"nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7"};
inline constexpr MessageType kTwistStamped{"geometry_msgs/TwistStamped",
                                           "98d34b0043a2093cf9d9345ab6eef12e"};
inline constexpr MessageType kTwistWithCovarianceStamped{"geometry_msgs/TwistWithCovarianceStamped",
                                                         "8927a1a12fb2607ceea095b2dc440a96"};
inline constexpr MessageType kPoseStamped{"geometry_msgs/PoseStamped",
                                          "d3812c3cbc69362b77dc0b19b345f8f5"};
inline constexpr MessageType kPoseWithCovarianceStamped{"geometry_msgs/PoseWithCovarianceStamped",
                                                        "953b798c0f514ff060a53a3498ce6246"};
inline constexpr MessageType kImu{"sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2"};
inline constexpr MessageType kNavSatFix{"sensor_msgs/NavSatFix",
                                        "2d3a8cd499b9b4a0249fb98fd05cfa48"};
inline constexpr MessageType kTf2{"tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec"};
inline constexpr MessageType kTf{"tf/tfMessage", "94810edda583a504dfda3829e70d7eec"};

/// Only written.
inline constexpr MessageType kDiagnosticArray{"diagnostic_msgs/DiagnosticArray",
                                              "60810da900de1dd6ddd437c3503511da"};

/// All that are read.
std::span<const MessageType> KnownTypes();

/// The known type of that name, or nullptr.
const MessageType* FindType(absl::string_view name);

/// Definition of a type that we write (message_writer.h), with those of its parts, as bags hold it;
/// empty for others.
std::string DefinitionOf(const MessageType& type);

}  // namespace dcloc::rosbag
