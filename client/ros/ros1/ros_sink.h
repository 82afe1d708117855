#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>
#include <vector>

#include "client/ros/node_messages.h"

namespace dcloc::node {

/// Publishes what the node says as messages of ROS 1: `~pose`, `~odometry`, /tf, /diagnostics, and
/// warnings to the log.
class RosSink final : public NodeSink {
 public:
  RosSink(::ros::NodeHandle global, ::ros::NodeHandle own);

  /// Tells a master that was started anew of its topics.
  void AdvertiseAnew();

  void Publish(const PoseMessage& pose) override;
  void Publish(const OdometryMessage& odometry) override;
  void Publish(const rosbag::Transform& transform) override;
  void Publish(const std::vector<Diagnostic>& diagnostics) override;
  void Warn(const std::string& text) override;

 private:
  void Advertise();

  ::ros::NodeHandle global_;
  ::ros::NodeHandle own_;
  ::ros::Publisher pose_;
  ::ros::Publisher odometry_;
  ::ros::Publisher transform_;
  ::ros::Publisher diagnostics_;
};

}  // namespace dcloc::node
