#include "client/ros/ros1/ros_sink.h"

#include <ros/console.h>
#include <ros/time.h>

#include <chrono>
#include <cstdint>
#include <utility>

#include "client/ros/ros1/raw_message.h"
#include "client/rosbag/message_types.h"
#include "client/rosbag/message_writer.h"

namespace dcloc::node {
namespace {

constexpr std::uint32_t kOutgoingCount = 100;

::ros::Publisher AdvertiseTopic(::ros::NodeHandle& node, const std::string& topic,
                                const rosbag::MessageType& type) {
  ::ros::AdvertiseOptions options(topic, kOutgoingCount, type.md5sum, type.name,
                                  rosbag::DefinitionOf(type));
  return node.advertise(options);
}

Matrix6d MatrixOf(const Covariance& covariance) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(covariance.data());
}

rosbag::Motion MotionOf(const PoseMessage& pose) {
  rosbag::Motion motion;
  motion.header = {pose.stamp, pose.frame};
  motion.T_frame_child = pose.T_frame_vehicle;
  motion.pose_covariance = MatrixOf(pose.covariance);
  return motion;
}

Stamp Now() {
  return Stamp(std::chrono::nanoseconds(static_cast<std::int64_t>(::ros::Time::now().toNSec())));
}

}  // namespace

RosSink::RosSink(::ros::NodeHandle global, ::ros::NodeHandle own)
    : global_(std::move(global)), own_(std::move(own)) {
  Advertise();
}

void RosSink::Advertise() {
  pose_ = AdvertiseTopic(own_, "pose", rosbag::kPoseWithCovarianceStamped);
  odometry_ = AdvertiseTopic(own_, "odometry", rosbag::kOdometry);
  transform_ = AdvertiseTopic(global_, "/tf", rosbag::kTf2);
  diagnostics_ = AdvertiseTopic(global_, "/diagnostics", rosbag::kDiagnosticArray);
}

void RosSink::AdvertiseAnew() {
  for (::ros::Publisher* const publisher : {&pose_, &odometry_, &transform_, &diagnostics_}) {
    publisher->shutdown();
  }
  Advertise();
}

void RosSink::Publish(const PoseMessage& pose) {
  pose_.publish(RawMessage{rosbag::FormatPose(MotionOf(pose))});
}

void RosSink::Publish(const OdometryMessage& odometry) {
  rosbag::Motion motion = MotionOf(odometry.pose);
  motion.child_frame = odometry.child_frame;
  const auto& v = odometry.velocity;
  motion.velocity = EgoVelocity{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, std::nullopt};
  odometry_.publish(RawMessage{rosbag::FormatOdometry(motion)});
}

void RosSink::Publish(const rosbag::Transform& transform) {
  transform_.publish(RawMessage{rosbag::FormatTransforms({transform})});
}

void RosSink::Publish(const std::vector<Diagnostic>& diagnostics) {
  diagnostics_.publish(RawMessage{rosbag::FormatDiagnostics(Now(), diagnostics)});
}

void RosSink::Warn(const std::string& text) { ROS_WARN_STREAM(text); }

}  // namespace dcloc::node
