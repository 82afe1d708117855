#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

/// Reads a sequence ("sequence_108", or "108") from the official RadarScenes layout; `root` is the
/// folder with `sensors.json`, or the one that holds it as `data/`. Radars are "radar_1" to
/// "radar_4", or "1" to "4" in the request. Poses and ego-velocity are the odometry's, interpolated
/// at the scan. The annotators' labels are not used: a vehicle has none. NotFound for a name that
/// is not there; DataLoss names the file that is broken.
absl::StatusOr<Drive> ReadRadarScenesDrive(const std::filesystem::path& root,
                                           const DriveRequest& request);

/// The names of the sequences, sorted. NotFound where there is none.
absl::StatusOr<std::vector<std::string>> RadarScenesSequences(const std::filesystem::path& root);

}  // namespace dcloc
