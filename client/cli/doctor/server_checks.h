#pragma once

#include <Eigen/Core>
#include <chrono>
#include <optional>
#include <string>

#include "client/cli/doctor/finding.h"
#include "client/datasets/drive.h"
#include "client/sdk/channel.h"

namespace dcloc::cli {

/// What is checked of a server.
struct ServerCheckOptions {
  client::ChannelOptions channel;
  std::string map;                          ///< empty: no map is looked at
  std::optional<Eigen::Vector2d> at_map_m;  ///< a place that the map must cover
  std::string vehicle;                      ///< as which a session is opened, to compare clocks
  bool opens_session = false;
  std::chrono::milliseconds timeout = std::chrono::seconds(5);
};

/// Reaches the server, shakes hands, asks what the caller may do, looks for the map and whether it
/// covers the place and the poses of `drive`, if any. With `opens_session` a session is opened and
/// one scan without targets sent, to compare clocks. Changes nothing on the server. What cannot be
/// tried, since something before it failed, is skipped.
Findings CheckServer(const ServerCheckOptions& options, const Drive* drive);

}  // namespace dcloc::cli
