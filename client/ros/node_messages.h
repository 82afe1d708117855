#pragma once

#include <array>
#include <string>
#include <vector>

#include "client/rosbag/messages.h"
#include "core/geometry/pose.h"
#include "core/radar/stamp.h"

namespace dcloc::node {

// What the node publishes, as any middleware has it. Covariances are row by row, of (x, y, z,
// rotation about x, y, z) along and about the axes of the frame that is named (REP 103).
using Covariance = std::array<double, 36>;

/// geometry_msgs/PoseWithCovarianceStamped.
struct PoseMessage {
  Stamp stamp;
  std::string frame;
  Pose3 T_frame_vehicle;
  Covariance covariance{};
};

/// nav_msgs/Odometry. The velocity is in the child's frame.
struct OdometryMessage {
  PoseMessage pose;
  std::string child_frame;
  std::array<double, 6> velocity{};  ///< linear [m/s], then turn rate [rad/s]
};

using rosbag::Diagnostic;

/// Where the node's messages go. Called from several threads, one at a time.
class NodeSink {
 public:
  virtual ~NodeSink() = default;
  virtual void Publish(const PoseMessage& pose) = 0;
  virtual void Publish(const OdometryMessage& odometry) = 0;
  virtual void Publish(const rosbag::Transform& transform) = 0;
  virtual void Publish(const std::vector<Diagnostic>& diagnostics) = 0;
  /// For the log.
  virtual void Warn(const std::string& text) = 0;
};

}  // namespace dcloc::node
