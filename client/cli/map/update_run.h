#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/common/dataset_options.h"
#include "client/datasets/drive_request.h"
#include "core/update/map_update.h"

namespace dcloc::cli {

/// What `dcloc map update` was asked for, as it was written.
struct UpdateArguments {
  std::string base;
  DatasetArguments dataset;
  DriveRequest request;  ///< all but its name, which `drives` holds
  std::vector<std::string> drives;
  std::string held_out;  ///< one of `drives`; the last one if empty
  MapUpdateOptions options;
  std::string out;
  std::string report;
  bool force = false;
  bool json = false;
};

/// Updates the map, judges it, and writes it if it is better. FailedPrecondition says why it is
/// not; the report is written all the same.
absl::Status RunUpdate(const UpdateArguments& arguments);

}  // namespace dcloc::cli
