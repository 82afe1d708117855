#include "client/datasets/radarscenes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/datasets/files/file_error.h"
#include "client/datasets/finish_drive.h"
#include "client/datasets/radar_selection.h"
#include "client/datasets/radarscenes_tables.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

// The odometry of some recordings ends a little before the last scans.
constexpr double kMaxExtrapolation_s = 0.25;

std::string RadarId(std::int64_t sensor_id) { return absl::StrCat("radar_", sensor_id); }

// Requests may say "2" for "radar_2" and "108" for "sequence_108".
std::string WithPrefix(const std::string& name, const char* prefix) {
  const bool is_number =
      !name.empty() &&
      std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  return is_number ? prefix + name : name;
}

fs::path DataFolder(const fs::path& root) {
  std::error_code error;
  return fs::exists(root / "sensors.json", error) ? root : root / "data";
}

std::vector<std::string> SequencesOf(const fs::path& data) {
  std::error_code error;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(data, error)) {
    if (entry.is_directory(error)) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

absl::StatusOr<fs::path> FindSequence(const fs::path& data, const std::string& name) {
  const std::vector<std::string> names = SequencesOf(data);
  if (std::find(names.begin(), names.end(), name) != names.end()) return data / name;
  return absl::NotFoundError(absl::StrCat(data.string(), ": there is no sequence \"", name,
                                          "\"; the sequences are ", absl::StrJoin(names, ", ")));
}

// The publication gives a range resolution of 0.15 m and azimuths to about a degree.
RadarModel SeriesRadar(std::int64_t sensor_id, const Pose3& T_vehicle_radar) {
  RadarModel radar;
  radar.id = RadarId(sensor_id);
  radar.T_vehicle_radar = T_vehicle_radar;
  radar.range_sigma_m = 0.15;
  radar.range_rate_sigma_mps = 0.1;
  radar.azimuth_sigma_rad = kRadPerDeg;
  return radar;
}

absl::StatusOr<Rig> BuildRig(const std::map<std::int64_t, Pose3>& mounts,
                             std::vector<std::string> wanted) {
  std::vector<std::string> available;
  available.reserve(mounts.size());
  for (const auto& [id, mount] : mounts) available.push_back(RadarId(id));
  for (std::string& id : wanted) id = WithPrefix(id, "radar_");
  if (absl::Status status = CheckRadars(wanted, available); !status.ok()) return status;
  Rig rig;
  for (const auto& [id, mount] : mounts) {
    if (IsWanted(wanted, RadarId(id))) rig.radars.push_back(SeriesRadar(id, mount));
  }
  return rig;
}

struct Motion {
  Pose3 T_map_vehicle;
  EgoVelocity ego_velocity;
};

Pose2 PoseOf(const RadarScenesOdometry& row) { return {{row.x_m, row.y_m}, row.yaw_rad}; }

EgoVelocity VelocityOf(double vx_mps, double yaw_rate_radps) {
  return {{vx_mps, 0.0, 0.0}, {0.0, 0.0, yaw_rate_radps}, std::nullopt};
}

// Between two rows along the arc that joins them; beyond the ends by the last row's velocity.
absl::StatusOr<Motion> MotionAt(const std::vector<RadarScenesOdometry>& rows,
                                std::int64_t time_us) {
  const auto after = std::upper_bound(
      rows.begin(), rows.end(), time_us,
      [](std::int64_t time, const RadarScenesOdometry& row) { return time < row.timestamp_us; });
  if (after != rows.begin() && after != rows.end()) {
    const RadarScenesOdometry& before = *std::prev(after);
    const double weight = static_cast<double>(time_us - before.timestamp_us) /
                          static_cast<double>(after->timestamp_us - before.timestamp_us);
    const Pose2 T_before_after = PoseOf(before).Inverse() * PoseOf(*after);
    return Motion{Embed(PoseOf(before) * Exp(Eigen::Vector3d(weight * Log(T_before_after)))),
                  VelocityOf(std::lerp(before.vx_mps, after->vx_mps, weight),
                             std::lerp(before.yaw_rate_radps, after->yaw_rate_radps, weight))};
  }
  if (rows.empty()) return absl::DataLossError("data set \"odometry\" is empty");
  const RadarScenesOdometry& nearest = after == rows.end() ? rows.back() : rows.front();
  const double elapsed_s = 1e-6 * static_cast<double>(time_us - nearest.timestamp_us);
  if (std::abs(elapsed_s) > kMaxExtrapolation_s) {
    return absl::DataLossError(absl::StrCat("data set \"odometry\" has nothing within ",
                                            kMaxExtrapolation_s, " s of the scan at ", time_us,
                                            " us"));
  }
  const Eigen::Vector3d xi(nearest.vx_mps * elapsed_s, 0.0, nearest.yaw_rate_radps * elapsed_s);
  return Motion{Embed(PoseOf(nearest) * Exp(xi)),
                VelocityOf(nearest.vx_mps, nearest.yaw_rate_radps)};
}

bool IsUsable(const RadarScenesTarget& target) {
  return std::isfinite(target.range_m) && target.range_m > 0.0F &&
         std::isfinite(target.azimuth_rad) && std::isfinite(target.range_rate_mps) &&
         std::isfinite(target.rcs_dbsm);
}

absl::StatusOr<Scan> BuildScan(const RadarScenesScene& scene,
                               const std::vector<RadarScenesTarget>& targets) {
  if (scene.end > targets.size()) {
    return absl::DataLossError(absl::StrCat("the scene at ", scene.timestamp_us, " us ends at row ",
                                            scene.end, " of ", targets.size()));
  }
  Scan scan;
  scan.stamp = Stamp(std::chrono::microseconds(scene.timestamp_us));
  scan.radar_id = RadarId(scene.sensor_id);
  for (std::size_t i = scene.begin; i < scene.end; ++i) {
    const RadarScenesTarget& target = targets[i];
    if (target.sensor_id != scene.sensor_id || target.timestamp_us != scene.timestamp_us) {
      return absl::DataLossError(absl::StrCat("row ", i, " of \"radar_data\" is of sensor ",
                                              target.sensor_id, " at ", target.timestamp_us,
                                              " us; scenes.json says sensor ", scene.sensor_id,
                                              " at ", scene.timestamp_us, " us"));
    }
    if (!IsUsable(target)) continue;
    scan.range_m.push_back(target.range_m);
    scan.range_rate_mps.push_back(target.range_rate_mps);
    scan.azimuth_rad.push_back(target.azimuth_rad);
    scan.rcs_dbsm.push_back(target.rcs_dbsm);
  }
  if (absl::Status status = Validate(scan); !status.ok()) {
    return absl::DataLossError(
        absl::StrCat("the scene at ", scene.timestamp_us, " us: ", status.message()));
  }
  return scan;
}

absl::Status AddScans(const fs::path& sequence, Drive& drive) {
  const fs::path radar_data = sequence / "radar_data.h5";
  const auto scenes = ReadRadarScenesScenes(sequence / "scenes.json");
  if (!scenes.ok()) return scenes.status();
  const auto odometry = ReadRadarScenesOdometry(radar_data);
  if (!odometry.ok()) return odometry.status();
  const auto targets = ReadRadarScenesTargets(radar_data);
  if (!targets.ok()) return targets.status();
  for (const RadarScenesScene& scene : *scenes) {
    if (drive.rig.Find(RadarId(scene.sensor_id)) == nullptr) continue;
    auto scan = BuildScan(scene, *targets);
    if (!scan.ok()) return FileError(radar_data, scan.status().message());
    const auto motion = MotionAt(*odometry, scene.timestamp_us);
    if (!motion.ok()) return FileError(radar_data, motion.status().message());
    scan->ego_velocity = motion->ego_velocity;
    drive.scans.push_back({*std::move(scan), motion->T_map_vehicle});
  }
  if (drive.scans.empty()) return FileError(sequence / "scenes.json", "has no scene of its radars");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Drive> ReadRadarScenesDrive(const fs::path& root, const DriveRequest& request) {
  const fs::path data = DataFolder(root);
  const auto mounts = ReadRadarScenesMounts(data / "sensors.json");
  if (!mounts.ok()) return mounts.status();
  auto rig = BuildRig(*mounts, request.radars);
  if (!rig.ok()) return rig.status();
  Drive drive;
  drive.name = WithPrefix(request.name, "sequence_");
  drive.rig = *std::move(rig);
  const auto sequence = FindSequence(data, drive.name);
  if (!sequence.ok()) return sequence.status();
  if (absl::Status status = AddScans(*sequence, drive); !status.ok()) return status;
  if (absl::Status status = FinishDrive(request, drive); !status.ok()) {
    return FileError(*sequence, status.message());
  }
  return drive;
}

absl::StatusOr<std::vector<std::string>> RadarScenesSequences(const fs::path& root) {
  std::vector<std::string> names = SequencesOf(DataFolder(root));
  if (!names.empty()) return names;
  return absl::NotFoundError(absl::StrCat(root.string(), ": there is no folder of a sequence"));
}

}  // namespace dcloc
