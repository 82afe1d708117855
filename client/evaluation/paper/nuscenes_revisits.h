#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/radar/stamp.h"

namespace dcloc::paper {

/// A key frame of a scene, as revisits are looked for.
struct KeyFrame {
  Stamp stamp;
  Pose3 T_map_vehicle;
};

/// The front radar's key frames of a scene.
struct SceneTrack {
  std::string scene;
  std::string location;
  std::string vehicle;
  std::vector<KeyFrame> key_frames;  ///< ascending
};

/// Reads the tracks of all scenes of a nuScenes version folder, each table once whatever its size;
/// scenes by ascending time. DataLoss names the file that is broken.
absl::StatusOr<std::vector<SceneTrack>> ReadSceneTracks(const std::filesystem::path& tables);

/// A segment of a scene that an earlier one went through.
struct Revisit {
  std::string map_scene;
  std::string live_scene;
  Stamp begin;
  Stamp end;
};

struct RevisitOptions {
  double max_distance_m = 5.0;  ///< [0.01, 1000]
  double max_turn_rad = 0.5;    ///< [0, 3.2]: the radar sees other sides when driven against
  int min_pairs = 3;            ///< the paper's; [1, 1000]
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const RevisitOptions& options);

/// The paper's pairs: each key frame goes with its nearest neighbour among all earlier scenes of
/// the same location. A revisit is a run of at least `min_pairs` key frames with one scene.
/// Errors: invalid options.
absl::StatusOr<std::vector<Revisit>> FindRevisits(const std::vector<SceneTrack>& tracks,
                                                  const RevisitOptions& options = {});

}  // namespace dcloc::paper
