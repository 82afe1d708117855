#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// One radar sweep (or key-frame sample) of a scene, as the tables describe it.
struct NuScenesSweep {
  std::string channel;
  std::string filename;  ///< below the dataset's root
  Stamp stamp;
  Pose3 T_map_vehicle;
};

/// What the tables say of one scene's radars.
struct NuScenesScene {
  std::string location;
  std::map<std::string, Pose3> T_vehicle_radar;  ///< by channel; every radar that has a sweep
  std::vector<NuScenesSweep> sweeps;             ///< in the table's order
};

/// The names of the scenes in the tables in `folder`, in their order.
absl::StatusOr<std::vector<std::string>> ReadNuScenesSceneNames(
    const std::filesystem::path& folder);

/// Reads the scene called `name` from the tables in `folder` (".../v1.0-mini"). NotFound, naming
/// the scenes that there are, when it has none of that name; DataLoss naming the file and record
/// for a malformed table or a token that leads nowhere.
absl::StatusOr<NuScenesScene> ReadNuScenesScene(const std::filesystem::path& folder,
                                                const std::string& name);

}  // namespace dcloc
