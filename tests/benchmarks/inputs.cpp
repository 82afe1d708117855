#include "tests/benchmarks/inputs.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "client/datasets/dataset.h"
#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"
#include "core/localizer/localizer_options.h"
#include "core/odometry/ego_motion.h"

namespace dcloc::benchmarks {
namespace {

// A benchmark without its input has nothing to say.
template <typename T>
T OrExit(absl::StatusOr<T> value) {
  if (value.ok()) return *std::move(value);
  std::cerr << value.status() << '\n';
  std::exit(1);
}

Case MakeCase(std::string name, Drive map_drive, Drive live_drive) {
  Case made{.name = std::move(name),
            .map_drive = std::move(map_drive),
            .live_drive = std::move(live_drive),
            .map_bytes = {},
            .map = nullptr};
  made.map_bytes = OrExit(BuildMap(made.map_drive, {.name = made.name}));
  made.map = OrExit(RadarMap::FromBytes(made.map_bytes));
  return made;
}

Case RecordedCase(std::string name, const Dataset& dataset, const std::string& drive,
                  std::vector<std::string> map_radars, std::vector<std::string> live_radars) {
  return MakeCase(
      std::move(name),
      OrExit(ReadDrive(dataset, {.name = drive, .radars = std::move(map_radars), .beta_s = {}})),
      OrExit(ReadDrive(dataset, {.name = drive, .radars = std::move(live_radars), .beta_s = {}})));
}

}  // namespace

bool IsSmokeRun(int argc, char** argv) {
  const bool smoke = argc == 2 && std::string_view(argv[1]) == "--smoke";
  if (argc > 1 && !smoke) {
    std::cerr << "Usage: " << argv[0] << " [--smoke]\n";
    std::exit(2);
  }
  return smoke;
}

Case SimulatedCase(const std::string& name, double length_m) {
  SimulationOptions options;
  options.radar = name == "carla" ? RadarKind::kCarla : RadarKind::kArs408;
  options.length_m = length_m;
  options.seed = 4;
  const std::vector<PassOptions> passes = Passes(options);
  return MakeCase(name, OrExit(SimulatePass(options, passes[0])),
                  OrExit(SimulatePass(options, passes[1])));
}

std::vector<Case> RecordedCases() {
  const char* const root = std::getenv("DCLOC_DATA");
  if (root == nullptr) return {};
  const std::filesystem::path nuscenes = std::filesystem::path(root) / "nuscenes_dev";
  const std::filesystem::path radarscenes = std::filesystem::path(root) / "radarscenes_dev";
  std::vector<Case> cases;
  if (std::filesystem::exists(nuscenes)) {
    cases.push_back(RecordedCase("nuscenes", {DatasetFormat::kNuScenes, nuscenes, ""}, "scene-0061",
                                 {"RADAR_FRONT", "RADAR_FRONT_LEFT", "RADAR_FRONT_RIGHT"},
                                 {"RADAR_BACK_LEFT", "RADAR_BACK_RIGHT"}));
  }
  if (std::filesystem::exists(radarscenes)) {
    cases.push_back(RecordedCase("radarscenes", {DatasetFormat::kRadarScenes, radarscenes, ""},
                                 "sequence_108", {"radar_2", "radar_3"}, {"radar_1", "radar_4"}));
  }
  return cases;
}

std::vector<Query> Queries(const Case& drives, std::size_t stride, std::size_t max_count) {
  constexpr std::size_t kFirst = 10;
  const LocalizerOptions options;
  EgoMotion ego_motion(options.ego_motion);
  SubmapWindow window(options.scans_per_submap);
  const Rig& rig = drives.live_drive.rig;
  std::vector<Query> queries;
  for (std::size_t i = 0; i < drives.live_drive.scans.size() && queries.size() < max_count; ++i) {
    const auto& [scan, T_map_vehicle] = drives.live_drive.scans[i];
    const RadarModel& radar = *rig.Find(scan.radar_id);
    const EgoVelocity& velocity = ego_motion.Advance(scan, radar);
    window.Push(scan.stamp, static_cast<int>(&radar - rig.radars.data()),
                StaticPoints(scan, radar, velocity, options.static_points),
                ego_motion.since_previous());
    if (i < kFirst || (i - kFirst) % stride != 0) continue;
    Query query{.submap = window.Join(DriftCovariance::kAdded),
                .live = {},
                .local_map = LocalMap<2>(*drives.map, T_map_vehicle.translation_m,
                                         options.matcher.local_map_radius_m),
                .T_local_vehicle_true = {}};
    query.T_local_vehicle_true = Flatten(query.local_map.T_map_local().Inverse() * T_map_vehicle);
    query.live.reserve(query.submap.points.size());
    for (const RadarPoint& point : query.submap.points) {
      query.live.push_back({point.position_m.head<2>(), point.covariance_m2.topLeftCorner<2, 2>()});
    }
    queries.push_back(std::move(query));
  }
  return queries;
}

Pose2 StartFor(const Query& query, std::size_t number, double translation_m, double rotation_deg) {
  const double direction_rad = 2.4 * static_cast<double>(number);  // the golden angle: all sides
  const double turn_rad = rotation_deg * std::numbers::pi / 180.0 * (number % 2 == 0 ? 1.0 : -1.0);
  Pose2 start = query.T_local_vehicle_true;
  start.translation_m +=
      translation_m * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
  start.yaw_rad = WrapAngle(start.yaw_rad + turn_rad);
  return start;
}

}  // namespace dcloc::benchmarks
