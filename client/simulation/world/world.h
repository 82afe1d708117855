#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/simulation/world/path.h"
#include "client/simulation/world/scatterer.h"
#include "core/geometry/pose.h"

namespace dcloc::simulation {

enum class WorldKind { kTown, kHighway };

/// A straight street that crosses the route; its traffic goes from `begin_m` to `end_m`.
struct CrossStreet {
  Eigen::Vector2d begin_m;
  Eigen::Vector2d end_m;
};

/// A lane along the route: `offset_m` left of it; `direction` is +1 with the route, -1 against it.
struct Lane {
  double offset_m = 0.0;
  int direction = 1;
  double speed_mps = 0.0;  ///< of its traffic, where that does not follow the ego vehicle's
  double vehicles_per_km = 0.0;
};

/// A straight segment of the route between two smooth walls, where nothing else is: it shows how
/// far it is to either side and where ahead is, but not how far one has come.
struct Tunnel {
  double begin_m = 0.0;  ///< along the route
  double end_m = 0.0;
  double half_width_m = 0.0;  ///< from the route to either wall
};

/// What does not move or change: a flat piece of land (z = 0 everywhere) with a route through it.
///
/// Map frame: x along the route's first metres, z up, the origin at the route's start.
/// The route has a lead-in and a lead-out, so that a drive sees world ahead and behind throughout:
/// a drive of `length_m` uses [drive_begin_m, drive_begin_m + length_m] of it. A route that is a
/// ring has neither; it is longer or shorter than a drive.
struct World {
  std::string name;
  Path route;
  double drive_begin_m = 0.0;
  double length_m = 0.0;
  double max_lateral_acceleration_mps2 = 3.0;  ///< that drivers accept here

  std::vector<Scatterer> scatterers;
  std::vector<Wall> walls;
  std::optional<Tunnel> tunnel;

  /// Where a vehicle may stand, each with the pose of its middle.
  std::vector<Pose2> parking_slots;
  double parking_occupancy = 0.0;

  std::vector<double> ego_lane_offsets_m;  ///< passes take them in turn
  std::vector<Lane> lanes;
  std::vector<CrossStreet> cross_streets;
  std::vector<double> stop_lines_m;  ///< along the route
  double truck_share = 0.0;
};

/// Worlds depend on their arguments alone; `length_m` > 0 is the length of a drive. In its middle a
/// tunnel of `tunnel_m`, 100 m shorter than the drive at least; 0 for none.
World MakeTown(std::uint64_t seed, double length_m, double tunnel_m = 0.0);
/// A town whose route is a ring of about `lap_m`.
World MakeTownRing(std::uint64_t seed, double length_m, double lap_m);
World MakeHighway(std::uint64_t seed, double length_m, double tunnel_m = 0.0);
World MakeWorld(WorldKind kind, std::uint64_t seed, double length_m, double tunnel_m = 0.0);

}  // namespace dcloc::simulation
