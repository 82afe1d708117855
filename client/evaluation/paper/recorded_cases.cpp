#include "client/evaluation/paper/recorded_cases.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/datasets/dataset.h"
#include "client/datasets/files/json_file.h"
#include "client/evaluation/paper/nuscenes_revisits.h"

namespace dcloc::paper {
namespace {

namespace fs = std::filesystem;

constexpr double kMinWay_m = 20.0;  // who stands still tells nothing of a map

bool Exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

// `folder` and what is in it, by name.
std::vector<fs::path> FolderAndSubfolders(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(error)) folders.push_back(entry.path());
  }
  std::ranges::sort(folders);
  folders.insert(folders.begin(), folder);
  return folders;
}

// Folders of tables in a nuScenes root: v1.0-trainval, v1.0-test, ...
std::vector<std::string> NuScenesVersions(const fs::path& root) {
  std::vector<std::string> versions;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(root, error)) {
    const std::string name = entry.path().filename().string();
    if (absl::StartsWith(name, "v1.0-") && Exists(entry.path() / "sample_data.json")) {
      versions.push_back(name);
    }
  }
  std::ranges::sort(versions);
  return versions;
}

double Way(const SceneTrack& track) {
  double way_m = 0.0;
  for (std::size_t i = 1; i < track.key_frames.size(); ++i) {
    way_m += (track.key_frames[i].T_map_vehicle.translation_m -
              track.key_frames[i - 1].T_map_vehicle.translation_m)
                 .norm();
  }
  return way_m;
}

std::function<absl::StatusOr<DrivePair>()> Loader(const Dataset& dataset, const DriveRequest& map,
                                                  const DriveRequest& live) {
  return [=]() -> absl::StatusOr<DrivePair> {
    auto map_drive = ReadDrive(dataset, map);
    if (!map_drive.ok()) return map_drive.status();
    auto live_drive = ReadDrive(dataset, live);
    if (!live_drive.ok()) return live_drive.status();
    return DrivePair{*std::move(map_drive), *std::move(live_drive)};
  };
}

// The scans of the revisit, and those of a sub-map before it.
void Trim(const Revisit& revisit, Drive& drive) {
  constexpr auto kLead = std::chrono::seconds(1);
  std::erase_if(drive.scans, [&](const DriveScan& entry) {
    return entry.scan.stamp < revisit.begin - kLead || entry.scan.stamp > revisit.end;
  });
}

Case RevisitCase(const Dataset& dataset, const Revisit& revisit, std::size_t number) {
  Case item{.set = "nuScenes, revisits",
            .name = absl::StrCat("nuscenes-", dataset.version, "-", number, "-", revisit.live_scene,
                                 "-in-", revisit.map_scene),
            .purpose = Purpose::kAblations};
  const auto load = Loader(dataset, {.name = revisit.map_scene, .radars = {"RADAR_FRONT"}},
                           {.name = revisit.live_scene, .radars = {"RADAR_FRONT"}});
  item.load = [load, revisit]() -> absl::StatusOr<DrivePair> {
    auto drives = load();
    if (drives.ok()) Trim(revisit, drives->live);
    return drives;
  };
  return item;
}

// Other scenes of the vehicle: the two with the longest way.
std::vector<std::string> CalibrationScenes(const std::vector<SceneTrack>& tracks,
                                           const SceneTrack& judged) {
  constexpr std::size_t kMaxScenes = 2;
  std::vector<const SceneTrack*> others;
  for (const SceneTrack& track : tracks) {
    if (track.scene == judged.scene || track.vehicle != judged.vehicle) continue;
    if (Way(track) >= kMinWay_m) others.push_back(&track);
  }
  std::ranges::stable_sort(others, std::greater(), [](const SceneTrack* t) { return Way(*t); });
  if (others.size() > kMaxScenes) others.resize(kMaxScenes);
  std::vector<std::string> names;
  names.reserve(others.size());
  for (const SceneTrack* track : others) names.push_back(track->scene);
  return names;
}

std::function<absl::StatusOr<std::vector<Drive>>()> CalibrationLoader(
    const Dataset& dataset, const std::vector<std::string>& names) {
  if (names.empty()) return nullptr;
  return [=]() -> absl::StatusOr<std::vector<Drive>> {
    std::vector<Drive> drives;
    for (const std::string& name : names) {
      auto drive = ReadDrive(dataset, {.name = name});
      if (!drive.ok()) return drive.status();
      drives.push_back(*std::move(drive));
    }
    return drives;
  };
}

Case FrontRearCase(const Dataset& dataset, const std::vector<SceneTrack>& tracks,
                   const SceneTrack& track) {
  return {.set = "nuScenes, front map and rear radars",
          .name = absl::StrCat("nuscenes-", dataset.version, "-", track.scene, "-rear"),
          .purpose = Purpose::kAblations,
          .load = Loader(dataset,
                         {.name = track.scene,
                          .radars = {"RADAR_FRONT", "RADAR_FRONT_LEFT", "RADAR_FRONT_RIGHT"}},
                         {.name = track.scene, .radars = {"RADAR_BACK_LEFT", "RADAR_BACK_RIGHT"}}),
          .load_calibration = CalibrationLoader(dataset, CalibrationScenes(tracks, track))};
}

absl::Status AddNuScenes(const Dataset& dataset, std::vector<Case>& cases) {
  const auto tracks = ReadSceneTracks(dataset.root / dataset.version);
  if (!tracks.ok()) return tracks.status();
  const auto revisits = FindRevisits(*tracks);
  if (!revisits.ok()) return revisits.status();
  for (std::size_t i = 0; i < revisits->size(); ++i) {
    cases.push_back(RevisitCase(dataset, (*revisits)[i], i));
  }
  if (!revisits->empty()) return absl::OkStatus();
  for (const SceneTrack& track : *tracks) {
    if (Way(track) >= kMinWay_m) cases.push_back(FrontRearCase(dataset, *tracks, track));
  }
  return absl::OkStatus();
}

enum class Half { kFirst, kSecond };

void KeepHalf(Half half, Drive& drive) {
  if (drive.scans.empty()) return;
  const Stamp first = drive.scans.front().scan.stamp;
  const Stamp middle = first + (drive.scans.back().scan.stamp - first) / 2;
  std::erase_if(drive.scans, [&](const DriveScan& entry) {
    return (entry.scan.stamp < middle) != (half == Half::kFirst);
  });
}

// One half of a sequence is localized in the map of the whole, and the rig calibrated on the other.
Case HalfSequenceCase(const Dataset& dataset, const std::string& sequence, Half half) {
  const bool is_first = half == Half::kFirst;
  Case item{
      .set = "RadarScenes, front map and side radars",
      .name = absl::StrCat("radarscenes-", sequence, is_first ? "-first" : "-second", "-half"),
      .query_interval_s = 1.0};
  const auto load = Loader(dataset, {.name = sequence, .radars = {"radar_2", "radar_3"}},
                           {.name = sequence, .radars = {"radar_1", "radar_4"}});
  item.load = [load, half]() -> absl::StatusOr<DrivePair> {
    auto drives = load();
    if (drives.ok()) KeepHalf(half, drives->live);
    return drives;
  };
  const auto load_all = CalibrationLoader(dataset, {sequence});
  item.load_calibration = [=]() -> absl::StatusOr<std::vector<Drive>> {
    auto drives = load_all();
    if (drives.ok()) KeepHalf(is_first ? Half::kSecond : Half::kFirst, drives->front());
    return drives;
  };
  return item;
}

absl::Status AddRadarScenes(const fs::path& root, const fs::path& data, std::vector<Case>& cases) {
  const auto document = ReadJson(data / "sequences.json");
  if (!document.ok()) return document.status();
  const auto sequences = document->find("sequences");
  if (sequences == document->end() || !sequences->is_object()) {
    return absl::DataLossError(
        absl::StrCat((data / "sequences.json").string(), ": \"sequences\" must be an object"));
  }
  for (const auto& [name, sequence] : sequences->items()) {
    if (!Exists(data / name)) continue;
    const Dataset dataset{DatasetFormat::kRadarScenes, root, ""};
    for (const Half half : {Half::kFirst, Half::kSecond}) {
      cases.push_back(HalfSequenceCase(dataset, name, half));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<Case>> RecordedCases(const fs::path& folder) {
  std::vector<Case> cases;
  bool has_found = false;
  for (const fs::path& root : FolderAndSubfolders(folder)) {
    for (const std::string& version : NuScenesVersions(root)) {
      has_found = true;
      const Dataset dataset{DatasetFormat::kNuScenes, root, version};
      if (absl::Status status = AddNuScenes(dataset, cases); !status.ok()) return status;
    }
    for (const fs::path& data : {root, root / "data"}) {
      if (!Exists(data / "sensors.json") || !Exists(data / "sequences.json")) continue;
      // "data" itself is met again among the subfolders of its root.
      if (data == root && root.filename() == "data" && root != folder) continue;
      has_found = true;
      if (absl::Status status = AddRadarScenes(root, data, cases); !status.ok()) return status;
    }
  }
  if (!has_found) {
    return absl::NotFoundError(
        absl::StrCat(folder.string(),
                     ": holds neither nuScenes tables (v1.0-*) nor RadarScenes (sensors.json)"));
  }
  return cases;
}

}  // namespace dcloc::paper
