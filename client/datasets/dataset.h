#pragma once

#include <filesystem>
#include <string>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

enum class DatasetFormat { kNuScenes, kRadarScenes };

/// A data set on disk.
struct Dataset {
  DatasetFormat format = DatasetFormat::kNuScenes;
  std::filesystem::path root;
  std::string version;  ///< nuScenes only; may be empty where there is just one
};

/// Reads a drive of the data set with its format's default options.
absl::StatusOr<Drive> ReadDrive(const Dataset& dataset, const DriveRequest& request);

}  // namespace dcloc
