#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/cli/common/dataset_options.h"
#include "client/datasets/drive_request.h"

namespace dcloc::cli {

/// What `dcloc dataset inspect` was asked for, as it was written.
struct InspectArguments {
  std::string path;          ///< a bag, or the folder of a data set; empty: dataset.root
  DatasetArguments dataset;  ///< its format may be empty: then by what lies in the folder
  DriveRequest drive;        ///< its name may be empty: then the only one, or a list
  std::string mapping_file;  ///< where the mapping that the data suggest is written; may be empty
  bool json = false;
};

/// Prints what the drive or the data set holds. What was found before an error is printed too.
absl::Status RunInspect(InspectArguments arguments);

}  // namespace dcloc::cli
