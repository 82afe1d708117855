#include "client/datasets/nuscenes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/datasets/can_bus.h"
#include "client/datasets/files/check_range.h"
#include "client/datasets/files/file_error.h"
#include "client/datasets/files/radar_pcd.h"
#include "client/datasets/finish_drive.h"
#include "client/datasets/nuscenes_tables.h"
#include "client/datasets/radar_selection.h"
#include "client/datasets/rig_file.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<fs::path> FindTables(const fs::path& root, const std::string& version) {
  std::error_code error;
  std::vector<std::string> versions;
  for (const auto& entry : fs::directory_iterator(root, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("v1.0-") && entry.is_directory(error)) versions.push_back(name);
  }
  std::sort(versions.begin(), versions.end());
  if (versions.empty()) {
    return absl::NotFoundError(
        absl::StrCat(root.string(), ": there is no v1.0-* folder with nuScenes tables"));
  }
  if (version.empty() && versions.size() == 1) return root / versions[0];
  if (version.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(root.string(), ": choose a version, there are ",
                                                   absl::StrJoin(versions, ", ")));
  }
  if (std::find(versions.begin(), versions.end(), version) == versions.end()) {
    return absl::NotFoundError(absl::StrCat(root.string(), ": there is no version \"", version,
                                            "\"; there are ", absl::StrJoin(versions, ", ")));
  }
  return root / version;
}

// What an ARS408's target list shows: x and y in steps of 0.1 to 0.2 m, speeds in steps of 0.25
// m/s.
RadarModel Ars408(const std::string& channel, const Pose3& T_vehicle_radar) {
  RadarModel radar;
  radar.id = channel;
  radar.T_vehicle_radar = T_vehicle_radar;
  radar.range_sigma_m = 0.15;
  radar.range_rate_sigma_mps = 0.12;
  radar.azimuth_sigma_rad = kRadPerDeg;
  return radar;
}

absl::StatusOr<Rig> BuildRig(const NuScenesScene& scene, const fs::path& tables,
                             const DriveRequest& request) {
  std::vector<std::string> channels;
  for (const auto& [channel, T_vehicle_radar] : scene.T_vehicle_radar) channels.push_back(channel);
  if (absl::Status status = CheckRadars(request.radars, channels); !status.ok()) return status;
  Rig rig;
  for (const auto& [channel, T_vehicle_radar] : scene.T_vehicle_radar) {
    if (!IsWanted(request.radars, channel)) continue;
    rig.radars.push_back(Ars408(channel, T_vehicle_radar));
  }
  std::error_code error;
  if (fs::exists(tables / kRigFileName, error)) {
    if (absl::Status status = ApplyRigFile(tables / kRigFileName, rig); !status.ok()) return status;
  }
  return rig;
}

bool Passes(const RadarPcdTarget& target, const NuScenesTargetFilter& filter) {
  const auto contains = [](const std::vector<int>& codes, int code) {
    return std::find(codes.begin(), codes.end(), code) != codes.end();
  };
  return contains(filter.invalid_states, target.invalid_state) &&
         contains(filter.ambig_states, target.ambig_state) &&
         contains(filter.dyn_props, target.dyn_prop);
}

// Cartesian to polar. The velocity is projected on the line of sight in the plane, which is the
// whole of it for the official files (z = 0); files with elevation hold the range rate along it.
void AddTarget(const RadarPcdTarget& target, bool has_elevation, Scan& scan) {
  const float planar_m = std::hypot(target.x_m, target.y_m);
  if (!(planar_m > 0.0F)) return;  // no line of sight
  scan.range_m.push_back(has_elevation ? std::hypot(planar_m, target.z_m) : planar_m);
  scan.range_rate_mps.push_back((target.x_m * target.vx_mps + target.y_m * target.vy_mps) /
                                planar_m);
  scan.azimuth_rad.push_back(std::atan2(target.y_m, target.x_m));
  if (has_elevation) scan.elevation_rad.push_back(std::atan2(target.z_m, planar_m));
  scan.rcs_dbsm.push_back(target.rcs_dbsm);
}

absl::StatusOr<Scan> ReadScan(const fs::path& path, const NuScenesSweep& sweep,
                              const RadarModel& radar, const NuScenesTargetFilter& filter) {
  const auto targets = ReadRadarPcd(path);
  if (!targets.ok()) return targets.status();
  Scan scan;
  scan.stamp = sweep.stamp;
  scan.radar_id = radar.id;
  for (const RadarPcdTarget& target : *targets) {
    if (Passes(target, filter)) AddTarget(target, radar.has_elevation, scan);
  }
  if (absl::Status status = Validate(scan); !status.ok()) return FileError(path, status.message());
  return scan;
}

// Few scenes lack a bus log, and those can be driven by Doppler alone: no file is no error.
absl::StatusOr<std::optional<VelocityLog>> ReadVelocities(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return std::optional<VelocityLog>();
  auto log = ReadCanBusPose(path);
  if (!log.ok()) return log.status();
  return std::optional<VelocityLog>(*std::move(log));
}

}  // namespace

absl::Status Validate(const NuScenesOptions& options) {
  return CheckRange("max_can_bus_age",
                    std::chrono::duration<double>(options.max_can_bus_age).count(), 0.0, 3600.0);
}

absl::StatusOr<Drive> ReadNuScenesDrive(const fs::path& root, const DriveRequest& request,
                                        const NuScenesOptions& options) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  const auto tables = FindTables(root, options.version);
  if (!tables.ok()) return tables.status();
  const auto scene = ReadNuScenesScene(*tables, request.name);
  if (!scene.ok()) return scene.status();
  auto rig = BuildRig(*scene, *tables, request);
  if (!rig.ok()) return rig.status();
  const auto velocities = ReadVelocities(root / "can_bus" / (request.name + "_pose.json"));
  if (!velocities.ok()) return velocities.status();

  Drive drive;
  drive.name = request.name;
  drive.place = scene->location;
  drive.rig = *std::move(rig);
  for (const NuScenesSweep& sweep : scene->sweeps) {
    const RadarModel* radar = drive.rig.Find(sweep.channel);
    if (radar == nullptr) continue;
    auto scan = ReadScan(root / sweep.filename, sweep, *radar, options.filter);
    if (!scan.ok()) return scan.status();
    if (velocities->has_value()) {
      scan->ego_velocity = (*velocities)->At(sweep.stamp, options.max_can_bus_age);
    }
    drive.scans.push_back({*std::move(scan), sweep.T_map_vehicle});
  }
  if (velocities->has_value() && std::ranges::none_of(drive.scans, [](const DriveScan& entry) {
        return entry.scan.ego_velocity.has_value();
      })) {
    drive.notes.push_back(absl::StrFormat(
        "no sample of %s_pose.json is within %.1f s of any scan: are they of one clock?",
        request.name, std::chrono::duration<double>(options.max_can_bus_age).count()));
  }
  if (absl::Status status = FinishDrive(request, drive); !status.ok()) {
    return FileError(*tables, status.message());
  }
  return drive;
}

absl::StatusOr<std::vector<std::string>> NuScenesScenes(const fs::path& root,
                                                        const std::string& version) {
  const absl::StatusOr<fs::path> tables = FindTables(root, version);
  if (!tables.ok()) return tables.status();
  return ReadNuScenesSceneNames(*tables);
}

}  // namespace dcloc
