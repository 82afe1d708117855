#include "client/simulation/world/tunnel.h"

#include <algorithm>
#include <cmath>

#include "client/simulation/world/steps.h"

namespace dcloc::simulation {
namespace {

constexpr double kStraightEnds = 5.0;     // of the route before and after a tunnel [m]
constexpr double kBehindWalls = 1.5;      // cleared, too, as a wall's skin lets it be seen [m]
constexpr double kHeight = 8.0;           // [m]
constexpr double kPieceLength = 20.0;     // [m]
constexpr double kReflectionsPerM = 0.6;  // of each wall

/// The ground that a tunnel takes.
class Tube {
 public:
  Tube(const World& world, double margin_m)
      : length_m_(world.tunnel->end_m - world.tunnel->begin_m),
        half_width_m_(world.tunnel->half_width_m + margin_m) {
    const PathPoint entry = world.route.At(world.tunnel->begin_m);
    T_tube_map_ = Pose2{entry.position_m, entry.heading_rad}.Inverse();
  }

  bool Holds(const Eigen::Vector2d& p_map) const {
    const Eigen::Vector2d p_tube = T_tube_map_ * p_map;
    return p_tube.x() >= 0.0 && p_tube.x() <= length_m_ && std::abs(p_tube.y()) <= half_width_m_;
  }

  bool Meets(const Eigen::Vector2d& begin_m, const Eigen::Vector2d& end_m) const {
    const double length_m = (end_m - begin_m).norm();
    return Holds(end_m) || std::ranges::any_of(Steps(0.0, length_m, 1.0), [&](double at) {
             return Holds(begin_m + at / length_m * (end_m - begin_m));
           });
  }

 private:
  Pose2 T_tube_map_;
  double length_m_;
  double half_width_m_;
};

void AddSmoothWall(double side, World& world) {
  const Tunnel& tunnel = *world.tunnel;
  for (const double at : Steps(tunnel.begin_m, tunnel.end_m, kPieceLength)) {
    const double end_m = std::min(at + kPieceLength, tunnel.end_m);
    world.walls.push_back({.begin_m = OffsetPoint(world.route, at, side * tunnel.half_width_m),
                           .end_m = OffsetPoint(world.route, end_m, side * tunnel.half_width_m),
                           .height_m = kHeight,
                           .loss_db = kOpaqueDb,
                           .is_mirror = true,
                           .reflections_per_m = kReflectionsPerM});
  }
}

}  // namespace

bool LayTunnelIfNear(World& world, double tunnel_m, double half_width_m, double reach_m) {
  if (tunnel_m <= 0.0 || world.tunnel) return false;
  const double planned_m = world.drive_begin_m + 0.5 * (world.length_m - tunnel_m);
  const double way_m = planned_m - world.route.length_m();
  if (way_m > reach_m) return false;
  world.route.Append(std::max(way_m, kStraightEnds), 0.0);
  const double begin_m = world.route.length_m();
  world.tunnel = Tunnel{begin_m, begin_m + tunnel_m, half_width_m};
  world.route.Append(tunnel_m + kStraightEnds, 0.0);
  return true;
}

void BuildTunnel(World& world) {
  if (!world.tunnel) return;
  const Tube tube(world, kBehindWalls);
  std::erase_if(world.scatterers, [&](const Scatterer& scatterer) {
    return tube.Holds(scatterer.position_m.head<2>());
  });
  std::erase_if(world.walls,
                [&](const Wall& wall) { return tube.Meets(wall.begin_m, wall.end_m); });
  std::erase_if(world.parking_slots,
                [&](const Pose2& slot) { return tube.Holds(slot.translation_m); });
  std::erase_if(world.cross_streets, [&](const CrossStreet& street) {
    return tube.Meets(street.begin_m, street.end_m);
  });
  for (const double side : {1.0, -1.0}) AddSmoothWall(side, world);
}

}  // namespace dcloc::simulation
