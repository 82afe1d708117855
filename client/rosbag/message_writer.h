#pragma once

#include <string>
#include <vector>

#include "client/rosbag/messages.h"

namespace dcloc::rosbag {

// Each gives a message's data. Sequence numbers are 0, as ROS itself takes no note of them.

/// One row of points.
std::string FormatPointCloud(const PointCloud& cloud);
std::string FormatTransforms(const std::vector<Transform>& transforms);

/// geometry_msgs/TwistWithCovarianceStamped; a covariance that is absent is written as zeros.
std::string FormatVelocity(const Header& header, const EgoVelocity& velocity);

/// geometry_msgs/PoseWithCovarianceStamped of a motion that has a pose. Here and below a covariance
/// that is absent is written as zeros.
std::string FormatPose(const Motion& motion);

/// nav_msgs/Odometry of a motion that has a pose and a velocity.
std::string FormatOdometry(const Motion& motion);

/// diagnostic_msgs/DiagnosticArray.
std::string FormatDiagnostics(Stamp stamp, const std::vector<Diagnostic>& entries);

}  // namespace dcloc::rosbag
