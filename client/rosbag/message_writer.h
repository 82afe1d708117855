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

}  // namespace dcloc::rosbag
