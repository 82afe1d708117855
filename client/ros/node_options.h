#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dcloc::node {

/// A parameter as a middleware holds it; whole numbers come as double.
using ParameterValue = std::variant<bool, double, std::string>;

/// The parameters of a vehicle's node, under the names of the members.
struct NodeOptions {
  std::string server = "localhost:50051";  ///< HOST:PORT
  std::string map;                         ///< on the server
  std::string vehicle = "ros";             ///< names it in logs and session lists
  std::string mapping;                     ///< path of a `dcloc_bag.json`: what the topics are
  std::string rig;                         ///< path of a `dcloc_rig.json`, or empty
  std::string odom_frame = "odom";         ///< TF gives its place in the map
  std::string initial_pose_topic = "/initialpose";
  std::string fix_topic;  ///< NavSatFix; empty: none
  std::string tls_ca;
  std::string tls_cert;
  std::string tls_key;
  std::string token_file;
  bool publish_tf = true;
  double odometry_rate_hz = 50.0;        ///< of `~odometry`; 0: none
  double max_velocity_wait_s = 0.05;     ///< a scan waits so long for the velocity at its stamp
  double radar_wait_s = 5.0;             ///< for all radars, before the session opens without some
  double fix_sigma_m = 5.0;              ///< of a NavSatFix that does not tell its own
  double max_queued_scan_count = 64.0;   ///< more are dropped
  double reconnect_give_up_s = 86400.0;  ///< a broken session is given up after this
};

/// The options that parameters name; others keep their defaults. InvalidArgument names the
/// parameter, its value and what it must be, also one that is not known, and one that is missing.
absl::StatusOr<NodeOptions> OptionsOf(const std::map<std::string, ParameterValue>& parameters);

/// OK, or InvalidArgument that names the parameter, the value and the bound.
absl::Status Validate(const NodeOptions& options);

}  // namespace dcloc::node
