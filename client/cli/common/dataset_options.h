#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/dataset.h"

namespace dcloc::cli {

/// Where a command's drives come from.
struct DatasetArguments {
  std::string format;  ///< a name of kDatasetFormatNames
  std::string root;
  std::string version;
};

/// Adds --dataset, --root and --version to `command`; fills `arguments` when it is parsed.
void AddDatasetOptions(CLI::App& command, DatasetArguments& arguments);

/// Reads a drive of the data set that the arguments name. What the reader has to say of it goes to
/// stderr.
absl::StatusOr<Drive> ReadDrive(const DatasetArguments& arguments, const DriveRequest& request);

/// Adds --rig and --beta-s, which override the data set's description of the radars, and --from-s
/// and --to-s, which select a part of the drive.
void AddDriveRequestOptions(CLI::App& command, DriveRequest& request);

/// Adds an option that takes radar ids, separated by commas.
void AddRadarsOption(CLI::App& command, const std::string& name, std::vector<std::string>& radars,
                     const std::string& description);

}  // namespace dcloc::cli
