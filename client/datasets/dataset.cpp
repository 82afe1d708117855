#include "client/datasets/dataset.h"

#include <chrono>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/datasets/hercules.h"
#include "client/datasets/nuscenes.h"
#include "client/datasets/radarscenes.h"
#include "client/datasets/rig_file.h"
#include "client/datasets/rosbag.h"
#include "client/datasets/zod.h"

namespace dcloc {
namespace {

absl::StatusOr<Drive> ReadAsDescribed(const Dataset& dataset, const DriveRequest& request) {
  switch (dataset.format) {
    case DatasetFormat::kNuScenes:
      return ReadNuScenesDrive(dataset.root, request, {.version = dataset.version});
    case DatasetFormat::kRadarScenes:
      return ReadRadarScenesDrive(dataset.root, request);
    case DatasetFormat::kRosbag:
      return ReadRosbagDrive(dataset.root, request);
    case DatasetFormat::kSnailRadar:
    case DatasetFormat::kNtu4dRadLm:
    case DatasetFormat::kMscRad4r:
      return ReadBagSetDrive(*BagSetOf(dataset.format), dataset.root, request);
    case DatasetFormat::kHercules:
      return ReadHerculesDrive(dataset.root, request);
    case DatasetFormat::kZod:
      return ReadZodDrive(dataset.root, request);
  }
  return absl::InvalidArgumentError(absl::StrFormat("format is %d; it is none of DatasetFormat",
                                                    static_cast<int>(dataset.format)));
}

absl::Status KeepPart(const DriveRequest& request, Drive& drive) {
  if (drive.scans.empty()) return absl::OkStatus();
  const Stamp first = drive.scans.front().scan.stamp;
  const auto left_out = [&](const DriveScan& scan) {
    const double since_s = std::chrono::duration<double>(scan.scan.stamp - first).count();
    return since_s < request.begin_s || since_s > request.end_s;
  };
  const double length_s =
      std::chrono::duration<double>(drive.scans.back().scan.stamp - first).count();
  std::erase_if(drive.scans, left_out);
  if (!drive.scans.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s has no scans from %g s to %g s; it lasts %.3f s", drive.name,
                      request.begin_s, request.end_s, length_s));
}

absl::Status Redescribe(const DriveRequest& request, Rig& rig) {
  if (absl::Status status = ApplyRigFile(request.rig_file, rig); !status.ok()) return status;
  for (RadarModel& radar : rig.radars) radar.beta_s = request.beta_s.value_or(radar.beta_s);
  return absl::OkStatus();
}

/// Names, or NotFound where there is none.
absl::StatusOr<std::vector<std::string>> Some(std::vector<std::string> names,
                                              const std::filesystem::path& root, const char* what) {
  if (!names.empty()) return names;
  return absl::NotFoundError(absl::StrCat(root.string(), ": holds no ", what));
}

/// The set of bags in folders below `root`, by what its authors put beside them.
std::optional<DatasetFormat> DetectBagSet(const std::filesystem::path& root) {
  std::error_code error;
  const std::vector<std::string> names = BagSetDrives(root);
  if (names.empty()) return std::nullopt;
  const std::filesystem::path first = root / names.front();
  const auto exists = [&](const std::filesystem::path& path) {
    return std::filesystem::exists(path, error);
  };
  if (exists(first.parent_path() / "gt_odom.txt")) return DatasetFormat::kNtu4dRadLm;
  if (exists(root / "ref_trajs_all") || exists(first / "tls_T_xt32.txt")) {
    return DatasetFormat::kSnailRadar;
  }
  for (const char* const place : {"URBAN_", "RURAL_", "LOOP_", "SMOKE_"}) {
    if (absl::StartsWith(first.filename().string(), place)) return DatasetFormat::kMscRad4r;
  }
  return std::nullopt;
}

}  // namespace

std::optional<BagSet> BagSetOf(DatasetFormat format) {
  switch (format) {
    case DatasetFormat::kSnailRadar:
      return BagSet::kSnailRadar;
    case DatasetFormat::kNtu4dRadLm:
      return BagSet::kNtu4dRadLm;
    case DatasetFormat::kMscRad4r:
      return BagSet::kMscRad4r;
    default:
      return std::nullopt;
  }
}

absl::StatusOr<DatasetFormat> DatasetFormatByName(absl::string_view name) {
  std::vector<std::string> names;
  for (const auto& [known, format] : kDatasetFormatNames) {
    if (name == known) return format;
    names.emplace_back(known);
  }
  return absl::InvalidArgumentError(
      absl::StrFormat("dataset is '%s'; it must be one of %s", name, absl::StrJoin(names, ", ")));
}

absl::StatusOr<DatasetFormat> DetectFormat(const std::filesystem::path& root) {
  std::error_code error;
  const auto exists = [&](const char* name) { return std::filesystem::exists(root / name, error); };
  if (exists("sensors.json") || exists("data/sensors.json")) return DatasetFormat::kRadarScenes;
  if (const auto bag_set = DetectBagSet(root)) return *bag_set;
  if (!BagNames(root).empty()) return DatasetFormat::kRosbag;
  if (!ZodDrives(root).empty()) return DatasetFormat::kZod;
  for (const auto& entry : std::filesystem::directory_iterator(root, error)) {
    const bool is_tables = absl::StartsWith(entry.path().filename().string(), "v1.0-");
    if (is_tables && entry.is_directory(error)) return DatasetFormat::kNuScenes;
  }
  if (!HerculesSequences(root).empty()) return DatasetFormat::kHercules;
  return absl::NotFoundError(absl::StrCat(
      root.string(),
      ": holds no v1.0-* folder of nuScenes, no sensors.json of RadarScenes, no bag, no "
      "PR_GT/Continental_gt.txt of HeRCULES, and no trainval-*.json of ZOD"));
}

absl::StatusOr<std::vector<std::string>> DriveNames(const Dataset& dataset) {
  switch (dataset.format) {
    case DatasetFormat::kNuScenes:
      return NuScenesScenes(dataset.root, dataset.version);
    case DatasetFormat::kRadarScenes:
      return RadarScenesSequences(dataset.root);
    case DatasetFormat::kRosbag:
      return Some(BagNames(dataset.root), dataset.root, "bag");
    case DatasetFormat::kSnailRadar:
    case DatasetFormat::kNtu4dRadLm:
    case DatasetFormat::kMscRad4r:
      return Some(BagSetDrives(dataset.root), dataset.root, "bag");
    case DatasetFormat::kHercules:
      return Some(HerculesSequences(dataset.root), dataset.root,
                  "folder with PR_GT/Continental_gt.txt");
    case DatasetFormat::kZod:
      return Some(ZodDrives(dataset.root), dataset.root, "trainval-*.json with drives");
  }
  return absl::InvalidArgumentError("format is none of DatasetFormat");
}

absl::StatusOr<Drive> ReadDrive(const Dataset& dataset, const DriveRequest& request) {
  if (absl::Status status = Validate(request); !status.ok()) return status;
  absl::StatusOr<Drive> drive = ReadAsDescribed(dataset, request);
  if (!drive.ok()) return drive;
  absl::Status status = KeepPart(request, *drive);
  if (status.ok() && !request.rig_file.empty()) status = Redescribe(request, drive->rig);
  if (!status.ok()) return status;
  return drive;
}

}  // namespace dcloc
