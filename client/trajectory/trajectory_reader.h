#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/trajectory/trajectory.h"
#include "client/trajectory/trajectory_format.h"

namespace dcloc {

/// Reads a trajectory with stamps: TUM, or CSV that names its columns (`x_m` or `x`, ... as
/// `FormatTrajectory` and `dcloc localize --out` write it; rows whose `state` is INITIALIZING are
/// left out). Rows come by ascending stamp, and of equal stamps the last one counts. Errors name
/// the path and the line: NotFound, DataLoss; InvalidArgument for a folder, and for the other
/// formats, which have no stamps or no poses.
absl::StatusOr<Trajectory> ReadTrajectory(const std::filesystem::path& path,
                                          TrajectoryFormat format);

/// The same of a file's text; `name` is for errors.
absl::StatusOr<Trajectory> ParseTrajectory(absl::string_view text, TrajectoryFormat format,
                                           absl::string_view name);

}  // namespace dcloc
