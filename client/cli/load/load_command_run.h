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

/// Runs the load test, or searches for the largest number of vehicles within the target, and prints
/// the result. Also an error if a scan was lost, an answer was wrong or the target was missed.
absl::Status RunLoadCommand(const LoadArguments& arguments);

}  // namespace dcloc::cli
