#pragma once

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/common/trajectory_options.h"

namespace dcloc::cli {

/// Writes the poses in the map that the recording `file` has as answers; gives their number. Errors
/// as of client::RecordingReader and of `WriteTrajectory`; then nothing is written.
absl::StatusOr<std::size_t> WriteRecordedTrajectory(const std::string& file,
                                                    const TrajectoryArguments& arguments);

}  // namespace dcloc::cli
