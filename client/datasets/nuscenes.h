#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

/// Which targets of a sweep are kept, by the device's own codes. The defaults are the nuScenes
/// devkit's. `dyn_prop` is not used to tell what moves: the device assumes that it looks ahead, so
/// the code is meaningless on the corner radars at speed; the Doppler residual in core decides.
struct NuScenesTargetFilter {
  std::vector<int> invalid_states = {0};               ///< 0: valid
  std::vector<int> ambig_states = {3};                 ///< 3: unambiguous
  std::vector<int> dyn_props = {0, 1, 2, 3, 4, 5, 6};  ///< all but 7, "stopped"
};

struct NuScenesOptions {
  std::string version;  ///< folder of the tables; may be empty when there is just one `v1.0-*`
  NuScenesTargetFilter filter;
  /// Bus samples further from a sweep than this give it no ego-velocity; [0, 1 h].
  std::chrono::nanoseconds max_can_bus_age = std::chrono::milliseconds(100);
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const NuScenesOptions& options);

/// Reads a scene's radars from the official nuScenes layout below `root`: the tables, the PCD files
/// they name and, where it exists, `can_bus/<scene>_pose.json`. Poses are `ego_pose`'s. Sigmas are
/// those of a Continental ARS408 with `beta_s` 0, unless a `dcloc_rig.json` lies beside the tables.
/// NotFound for a name, radar or version that is not there; DataLoss names the file that is broken.
absl::StatusOr<Drive> ReadNuScenesDrive(const std::filesystem::path& root,
                                        const DriveRequest& request,
                                        const NuScenesOptions& options = {});

/// The names of the scenes, in the table's order. Errors as above.
absl::StatusOr<std::vector<std::string>> NuScenesScenes(const std::filesystem::path& root,
                                                        const std::string& version);

}  // namespace dcloc
