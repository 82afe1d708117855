#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/common/calibration_option.h"
#include "client/cli/common/dataset_options.h"
#include "client/cli/common/trajectory_options.h"
#include "client/datasets/drive_request.h"
#include "core/geometry/geodetic_anchor.h"

namespace dcloc::cli {

/// What `dcloc map survey` was asked for, as it was written.
struct SurveyArguments {
  DatasetArguments dataset;
  DriveRequest request;  ///< all but its name, which `drives` holds
  std::vector<std::string> drives;
  std::vector<std::string> fix_files;
  std::optional<GeodeticAnchor> anchor;  ///< of the fixes' frame
  KeptParameters keep;
  bool no_calibration = false;
  std::string rig_out;
  std::string name;
  std::string out;
  std::string report;
  std::string checkpoint;  ///< file of how far it has come; empty for none
  TrajectoryArguments trajectory;
  bool compare_truth = false;
  bool json = false;
};

/// Surveys the drives, and writes the map and the files that were asked for, each whole or not at
/// all.
absl::Status RunSurvey(const SurveyArguments& arguments);

}  // namespace dcloc::cli
