#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/common/dataset_options.h"
#include "client/cli/common/trajectory_options.h"
#include "client/evaluation/runner.h"

namespace dcloc::cli {

/// What `dcloc evaluate` was asked for, as it was written.
struct EvaluateArguments {
  DatasetArguments dataset;
  DriveRequest map;                     ///< all but its name, which `map_drives` holds
  DriveRequest live;                    ///< all but its name, which `drives` holds
  std::vector<std::string> map_drives;  ///< one for all drives, or one for each
  std::vector<std::string> drives;
  std::string method = "dcloc";
  std::string protocol = "track";
  std::string initial = "truth";
  std::string ego_velocity = "sensor";
  std::optional<double> query_interval_s;
  std::vector<std::string> without;
  EvaluationOptions options;  ///< what is given by numbers
  std::string json_file;
  std::string csv_file;
  std::string report_file;
  TrajectoryArguments trajectory;        ///< a file for each drive
  std::optional<GeodeticAnchor> anchor;  ///< of the drives' frame, for the trajectories
};

/// Makes the map, localizes the drives, prints the metrics and writes the files that were asked
/// for.
absl::Status RunEvaluation(const EvaluateArguments& arguments);

}  // namespace dcloc::cli
