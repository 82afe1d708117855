#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/datasets/bag_presets.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

enum class DatasetFormat {
  kNuScenes,
  kRadarScenes,
  kRosbag,
  kSnailRadar,
  kNtu4dRadLm,
  kMscRad4r,
  kHercules,
  kZod
};

/// The formats by the names that users write.
inline constexpr std::array<std::pair<const char*, DatasetFormat>, 8> kDatasetFormatNames = {
    {{"nuscenes", DatasetFormat::kNuScenes},
     {"radarscenes", DatasetFormat::kRadarScenes},
     {"rosbag", DatasetFormat::kRosbag},
     {"snail-radar", DatasetFormat::kSnailRadar},
     {"ntu4dradlm", DatasetFormat::kNtu4dRadLm},
     {"msc-rad4r", DatasetFormat::kMscRad4r},
     {"hercules", DatasetFormat::kHercules},
     {"zod", DatasetFormat::kZod}}};

/// The format of that name; InvalidArgument names it, and those that there are.
absl::StatusOr<DatasetFormat> DatasetFormatByName(absl::string_view name);

/// A data set on disk.
struct Dataset {
  DatasetFormat format = DatasetFormat::kNuScenes;
  std::filesystem::path root;
  std::string version;  ///< nuScenes only; may be empty where there is just one
};

/// Which public set of bags the format is; nothing for others.
std::optional<BagSet> BagSetOf(DatasetFormat format);

/// The format by what lies in the folder `root`; a data set of ours is one of nuScenes. NotFound
/// where nothing of these formats does.
absl::StatusOr<DatasetFormat> DetectFormat(const std::filesystem::path& root);

/// The names of the drives that there are, in the data set's order. NotFound where there is none;
/// other errors are those of the format's reader.
absl::StatusOr<std::vector<std::string>> DriveNames(const Dataset& dataset);

/// Reads a drive of the data set with its format's default options. InvalidArgument names a field
/// of the request that makes no sense; other errors are those of the format's reader.
absl::StatusOr<Drive> ReadDrive(const Dataset& dataset, const DriveRequest& request);

}  // namespace dcloc
