#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "absl/status/status.h"
#include "client/trajectory/trajectory.h"

namespace dcloc::cli {

/// Where and how a command writes a trajectory, as it was written.
struct TrajectoryArguments {
  std::string file;    ///< empty: nowhere
  std::string format;  ///< a name of kTrajectoryFormatNames; empty: by the file's extension
};

/// Adds --trajectory-out and --trajectory-format; gives the first.
CLI::Option* AddTrajectoryOptions(CLI::App& command, TrajectoryArguments& arguments);

/// Whether a trajectory can be written so, before a command does its work. InvalidArgument for a
/// file whose format is not told, FailedPrecondition for one that needs an anchor without one.
absl::Status CheckTrajectory(const TrajectoryArguments& arguments, bool has_anchor);

/// Writes the file whole; nothing where none was asked for. FailedPrecondition for a trajectory
/// without poses, which leaves an older file as it is.
absl::Status WriteTrajectory(const TrajectoryArguments& arguments, const Trajectory& trajectory);

}  // namespace dcloc::cli
