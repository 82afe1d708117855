#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/simulation/world/steps.h"
#include "client/simulation/world/structures.h"
#include "client/simulation/world/town_plan.h"
#include "client/simulation/world/tunnel.h"
#include "client/simulation/world/world.h"

namespace dcloc::simulation {
namespace {

constexpr double kTownLeadIn = 50.0;   // [m]
constexpr double kTownLeadOut = 60.0;  // [m]
constexpr double kLaneOffset = 1.75;

Footprint Box(const Eigen::Vector2d& front_middle, double heading_rad, double side, double width_m,
              double depth_m) {
  // Counter-clockwise whether the house stands left (side 1) or right (-1) of the street.
  const Eigen::Vector2d half = 0.5 * width_m * side * Along(heading_rad);
  const Eigen::Vector2d back = depth_m * side * LeftOf(heading_rad);
  return {front_middle - half, front_middle + half, front_middle + half + back,
          front_middle - half + back};
}

// One side of a street: houses side by side, set back unevenly, gaps and yards between them.
void AddHouseRow(const Street& street, double side, TownPlan& plan, Builder& builder,
                 Random& random) {
  const double length_m = 2.0 * static_cast<double>(street.points_m.size() - 1);
  double at = Uniform(random, 0.0, 4.0);
  while (at + 8.0 < length_m) {
    const double width_m = Uniform(random, 8.0, 26.0);
    const auto middle =
        std::min(static_cast<std::size_t>((at + 0.5 * width_m) / 2.0), street.points_m.size() - 2);
    const Eigen::Vector2d step = street.points_m[middle + 1] - street.points_m[middle];
    const double heading_rad = std::atan2(step.y(), step.x());
    const double setback_m = kStreetHalfWidth + kSidewalk + Uniform(random, 0.0, 2.5);
    const Eigen::Vector2d front = street.points_m[middle] + side * setback_m * LeftOf(heading_rad);
    const Footprint house = Box(front, heading_rad, side, width_m, Uniform(random, 9.0, 15.0));
    if (plan.Claim(house)) {
      builder.AddBuilding(house, Uniform(random, 6.0, 18.0));
      at += width_m + (Chance(random, 0.65) ? 0.2 : Uniform(random, 2.5, 14.0));
    } else {
      at += 3.0;
    }
  }
}

void AddHouses(TownPlan& plan, World& world, Random& random) {
  Builder builder(world, random);
  for (const Street& street : plan.streets()) {
    AddHouseRow(street, 1.0, plan, builder, random);
    AddHouseRow(street, -1.0, plan, builder, random);
  }
}

void AddPoleRow(double side, const TownPlan& plan, World& world, Random& random) {
  Builder builder(world, random);
  double at = Uniform(random, 0.0, 20.0);
  while (at < world.route.length_m()) {
    const Eigen::Vector2d position =
        OffsetPoint(world.route, at, side * (kStreetHalfWidth + Uniform(random, 0.4, 1.8)));
    if (plan.DistanceFromStreets(position) > 0.3) {
      const bool is_tree = Chance(random, 0.35);
      builder.AddPole(position, Normal(random, is_tree ? -2.0 : 5.0, 3.0), is_tree ? 4.0 : 2.0,
                      is_tree ? 0.25 : 0.03);
    }
    at += Uniform(random, 8.0, 26.0);
  }
}

// Traffic lights and signs at the corners of the crossroads.
void AddCrossroadsPoles(const TownPlan& plan, World& world, Random& random) {
  Builder builder(world, random);
  for (const Crossroads& crossroads : plan.crossroads()) {
    for (int corner = 0; corner < 16; ++corner) {
      const double direction = 0.393 * corner + Uniform(random, -0.15, 0.15);
      const Eigen::Vector2d position =
          crossroads.centre_m + Uniform(random, 8.5, 12.5) * Along(direction);
      const double distance = plan.DistanceFromStreets(position);
      if (distance > 0.2 && distance < 2.0) {
        builder.AddPole(position, Normal(random, 7.0, 3.0), 2.5, 0.03);
      }
    }
  }
}

// Manhole covers and gratings lie flush in the road: weak, and seen from both sides.
void AddRoadPlates(World& world, Random& random) {
  Builder builder(world, random);
  for (const double at : RandomSteps(random, 5.0, world.route.length_m(), 10.0, 40.0)) {
    Eigen::Vector3d position;
    position << OffsetPoint(world.route, at, Uniform(random, -3.0, 3.0)), 0.02;
    builder.AddPlate(position, 0.0, std::numbers::pi, Normal(random, -6.0, 3.0));
  }
}

void AddParking(double side, const TownPlan& plan, World& world, Random& random) {
  double at = 5.0;
  while (at < world.route.length_m()) {
    const double row_end = at + Uniform(random, 20.0, 90.0);
    for (const double slot : RandomSteps(random, at, row_end, 5.8, 6.6)) {
      if (!plan.IsAwayFromCrossroads(slot, 8.0)) continue;
      const PathPoint point = world.route.At(slot);
      const Eigen::Vector2d position =
          point.position_m + side * (kStreetHalfWidth - 1.1 + Uniform(random, -0.15, 0.15)) *
                                 LeftOf(point.heading_rad);
      const double heading = point.heading_rad + (side > 0.0 ? std::numbers::pi : 0.0);
      world.parking_slots.push_back({position, WrapAngle(heading)});
    }
    at = row_end + Uniform(random, 8.0, 40.0);
  }
}

World EmptyTown(double length_m) {
  World world;
  world.name = "town";
  world.length_m = length_m;
  world.max_lateral_acceleration_mps2 = 3.5;
  world.parking_occupancy = 0.65;
  world.ego_lane_offsets_m = {-kLaneOffset};
  world.truck_share = 0.06;
  return world;
}

// What stands along the streets.
void Furnish(TownPlan& plan, std::uint64_t seed, World& world) {
  Random houses_random = MakeRandom(seed, Stream::kBuildings);
  AddHouses(plan, world, houses_random);

  Random furniture_random = MakeRandom(seed, Stream::kFurniture);
  AddCrossroadsPoles(plan, world, furniture_random);
  AddRoadPlates(world, furniture_random);
  Random parking_random = MakeRandom(seed, Stream::kParking);
  for (const double side : {1.0, -1.0}) {
    AddPoleRow(side, plan, world, furniture_random);
    AddParking(side, plan, world, parking_random);
  }
}

}  // namespace

World MakeTown(std::uint64_t seed, double length_m, double tunnel_m) {
  World world = EmptyTown(length_m);
  world.drive_begin_m = kTownLeadIn;
  world.lanes = {{kLaneOffset, -1, 10.5, 14.0}};
  Random route_random = MakeRandom(seed, Stream::kRoute);
  TownPlan plan(world, kTownLeadIn + length_m + kTownLeadOut, tunnel_m, route_random);
  Furnish(plan, seed, world);
  BuildTunnel(world);
  return world;
}

World MakeTownRing(std::uint64_t seed, double length_m, double lap_m) {
  World world = EmptyTown(length_m);
  // Drives may go either way round.
  world.lanes = {{kLaneOffset, -1, 10.5, 14.0}, {-kLaneOffset, 1, 10.5, 14.0}};
  Random route_random = MakeRandom(seed, Stream::kRoute);
  TownPlan plan(world, lap_m, route_random);
  Furnish(plan, seed, world);
  return world;
}

}  // namespace dcloc::simulation
