#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace dcloc {

/// Which drive of a dataset is read, and with which radars.
struct DriveRequest {
  std::string name;                 ///< "scene-0061", "sequence_108"
  std::vector<std::string> radars;  ///< ids; all radars of the drive when empty
  std::filesystem::path rig_file;   ///< corrections of the radars (rig_file.h), or empty
  std::optional<double> beta_s;     ///< in place of every radar's own, and of the rig file's;
                                    ///< [-1, 1]
  double begin_s = 0.0;             ///< since the first scan; earlier scans are left out
  double end_s = std::numeric_limits<double>::infinity();  ///< later scans are left out
};

/// OK, or InvalidArgument that names the field, the value and the bound. Whether the data set has
/// such a drive and such radars, its reader says.
absl::Status Validate(const DriveRequest& request);

}  // namespace dcloc
