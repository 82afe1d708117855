#include "client/evaluation/robustness/course.h"

#include <cmath>
#include <utility>

#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"

namespace dcloc::robustness {
namespace {

// When the live drive is between the walls of its world's tunnel.
std::vector<Episode> TunnelEpisodes(const simulation::World& world, const Drive& live) {
  if (!world.tunnel) return {};
  const simulation::PathPoint entry = world.route.At(world.tunnel->begin_m);
  const Pose2 T_tunnel_map = Pose2{entry.position_m, entry.heading_rad}.Inverse();
  const double length_m = world.tunnel->end_m - world.tunnel->begin_m;
  std::vector<Episode> episodes;
  for (const auto& [scan, T_map_vehicle] : live.scans) {
    const Eigen::Vector2d p = T_tunnel_map * Eigen::Vector2d(T_map_vehicle.translation_m.head<2>());
    const bool inside =
        p.x() >= 0.0 && p.x() <= length_m && std::abs(p.y()) <= world.tunnel->half_width_m;
    if (!inside) continue;
    if (episodes.empty()) episodes.push_back({scan.stamp, scan.stamp});
    episodes.back().end = scan.stamp;
  }
  return episodes;
}

}  // namespace

absl::StatusOr<Course> SimulateCourse(const SimulationOptions& options, const Pass& pass,
                                      const std::string& name) {
  const simulation::World world = MakeWorld(options);
  auto map = SimulatePassWithTruth(world, options,
                                   {.name = "map", .mean_speed_mps = options.map_speed_mps});
  if (!map.ok()) return map.status();
  SimulationOptions live_options = options;
  live_options.stops = pass.stops;
  auto live = SimulatePassWithTruth(
      world, live_options,
      {.name = name, .index = 1, .mean_speed_mps = pass.speed_kmh * kMpsPerKmh});
  if (!live.ok()) return live.status();
  std::vector<Episode> episodes = TunnelEpisodes(world, live->drive);
  return Course{std::move(map->drive), std::move(live->drive), std::move(episodes)};
}

absl::StatusOr<std::shared_ptr<const RadarMap>> MapOf(const Drive& drive) {
  auto bytes = BuildMap(drive, {.name = drive.name});
  if (!bytes.ok()) return bytes.status();
  return RadarMap::FromBytes(*std::move(bytes));
}

}  // namespace dcloc::robustness
