#pragma once

#include <ros/node_handle.h>

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "client/ros/node_options.h"

namespace dcloc::node {

/// The private parameters of a node. InvalidArgument names one that is a list or a struct.
absl::StatusOr<std::map<std::string, ParameterValue>> ReadParameters(const ::ros::NodeHandle& node);

}  // namespace dcloc::node
