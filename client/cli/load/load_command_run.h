#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/common/dataset_options.h"
#include "client/load/load_options.h"
#include "client/sdk/channel.h"

namespace dcloc::cli {

/// What `dcloc load` was asked for, as it was written.
struct LoadArguments {
  client::ChannelOptions server;
  std::string map;
  DatasetArguments dataset;
  std::vector<std::string> drives;
  std::vector<std::string> radars;
  load::LoadOptions options;
  double target_p99_ms = 0.0;  ///< 0: none
  bool search = false;
  int max_vehicle_count = 2000;  ///< of a search
  bool json = false;
  std::string plot;
};

/// Runs the load, or searches for the most vehicles that hold the target, and prints what came of
/// it. An error also when something was lost or wrong, or the target was not held.
absl::Status RunLoadCommand(const LoadArguments& arguments);

}  // namespace dcloc::cli
