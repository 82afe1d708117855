#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "client/simulation/world/steps.h"
#include "client/simulation/world/structures.h"
#include "client/simulation/world/tunnel.h"
#include "client/simulation/world/world.h"

namespace dcloc::simulation {
namespace {

constexpr double kHighwayLeadIn = 120.0;   // [m]
constexpr double kHighwayLeadOut = 260.0;  // [m]
// Offsets left of the route, which runs along the middle of the central reserve [m].
constexpr double kInnerRail = 1.0;
constexpr double kOuterRail = 15.0;
constexpr double kBarrier = 18.0;
constexpr std::array<double, 3> kLanes = {3.9, 7.6, 11.3};

void LayRoute(World& world, double tunnel_m, Random& random) {
  constexpr double kLongestBend = 600.0;  // [m]
  const double length_m = kHighwayLeadIn + world.length_m + kHighwayLeadOut;
  world.route.Append(60.0, 0.0);
  double turn = Chance(random, 0.5) ? 1.0 : -1.0;
  while (world.route.length_m() < length_m) {
    if (LayTunnelIfNear(world, tunnel_m, kOuterRail - 1.0, kLongestBend)) continue;
    world.route.AppendBend(turn * Uniform(random, 0.15, 0.5), Uniform(random, 450.0, 1100.0), 90.0);
    world.route.Append(Uniform(random, 20.0, 250.0), 0.0);
    turn = -turn;
  }
}

class Roadside {
 public:
  Roadside(World& world, Random& random)
      : world_(world), random_(random), builder_(world, random) {}

  // Posts stand at a fixed pitch, so that one post looks like the next, as on the road.
  void AddRail(double offset_m, double begin_m, double end_m, double pitch_m) {
    for (const double s : Steps(begin_m, end_m, pitch_m)) {
      builder_.AddRailSegment(At(s, offset_m), At(s + pitch_m, offset_m));
    }
  }

  void AddOuterRails(double side) {
    double s = 0.0;
    while (s < Length()) {
      const double end_m = std::min(Length(), s + Uniform(random_, 150.0, 500.0));
      AddRail(side * kOuterRail, s, end_m, 4.0);
      s = end_m + Uniform(random_, 10.0, 120.0);
    }
  }

  // Sound barriers in pieces; shrubs and trees in the open between them.
  void AddBarriersAndTrees(double side) {
    double s = Uniform(random_, -100.0, 100.0);
    while (s < Length()) {
      const double barrier_end = std::min(Length(), s + Uniform(random_, 80.0, 260.0));
      for (const double at : Steps(std::max(0.0, s), barrier_end, 20.0)) {
        const Eigen::Vector2d from = At(at, side * kBarrier);
        const Eigen::Vector2d to = At(std::min(at + 20.0, barrier_end), side * kBarrier);
        // Seen from the road: it lies right of begin -> end on the left side, and the other way.
        if ((to - from).norm() < 1.0) continue;
        builder_.AddBarrier(side > 0.0 ? from : to, side > 0.0 ? to : from, 3.5, 5.0);
      }
      const double open_end = barrier_end + Uniform(random_, 60.0, 300.0);
      for (const double at : RandomSteps(random_, barrier_end, open_end, 2.0, 14.0)) {
        builder_.AddPole(At(at, side * Uniform(random_, kBarrier, 40.0)), Normal(random_, 0.0, 4.0),
                         4.0, 0.3);
      }
      s = open_end;
    }
  }

  void AddSignsAndDelineators(double side) {
    for (const double s : Steps(Uniform(random_, 0.0, 50.0), Length(), 50.0)) {
      builder_.AddPole(At(s, side * (kOuterRail - 0.6)), Normal(random_, 0.0, 2.0), 0.9, 0.02);
    }
    for (const double s :
         RandomSteps(random_, Uniform(random_, 0.0, 80.0), Length(), 50.0, 200.0)) {
      AddSign(s, side, kOuterRail + Uniform(random_, 0.8, 1.6), 0.8, Uniform(random_, 1.5, 3.0));
      builder_.AddPole(At(s, side * (kOuterRail + 1.2)), Normal(random_, 5.0, 2.0), 1.5, 0.03);
    }
  }

  // A portal over one carriageway: two posts and the boards above the lanes.
  void AddGantries(double side) {
    for (const double s :
         RandomSteps(random_, Uniform(random_, 60.0, 300.0), Length(), 250.0, 550.0)) {
      builder_.AddPole(At(s, side * (kOuterRail + 0.8)), Normal(random_, 10.0, 2.0), 2.0, 0.05);
      builder_.AddPole(At(s, side * 0.3), Normal(random_, 8.0, 2.0), 2.0, 0.05);
      for (const double lane : kLanes) {
        AddSign(s, side, lane + Uniform(random_, -0.8, 0.8), 0.5, 5.6);
      }
    }
  }

  // Bridges over the road: abutments beside it and a pier in the middle.
  void AddBridges() {
    for (const double s :
         RandomSteps(random_, Uniform(random_, 150.0, 500.0), Length() - 14.0, 450.0, 900.0)) {
      const double end_m = s + Uniform(random_, 8.0, 14.0);
      for (const double side : {1.0, -1.0}) {
        const Eigen::Vector2d near = At(s, side * (kBarrier - 1.0));
        const Eigen::Vector2d far = At(end_m, side * (kBarrier - 1.0));
        const Eigen::Vector2d near_out = At(s, side * (kBarrier + 6.0));
        const Eigen::Vector2d far_out = At(end_m, side * (kBarrier + 6.0));
        builder_.AddBuilding(side > 0.0 ? Footprint{near, far, far_out, near_out}
                                        : Footprint{near, near_out, far_out, far},
                             6.0);
      }
      builder_.AddPole(At(0.5 * (s + end_m), 0.0), 12.0, 3.0, 0.2);
    }
  }

 private:
  double Length() const { return world_.route.length_m(); }
  Eigen::Vector2d At(double s_m, double offset_m) const {
    return OffsetPoint(world_.route, s_m, offset_m);
  }

  void AddSign(double s_m, double side, double offset_m, double half_sector_rad, double height_m) {
    // Right-hand traffic: boards on the right (side -1) face the drivers who come along the route.
    const double facing = world_.route.At(s_m).heading_rad + (side < 0.0 ? std::numbers::pi : 0.0);
    Eigen::Vector3d position;
    position << At(s_m, side * offset_m), height_m;
    builder_.AddPlate(position, facing, half_sector_rad, Normal(random_, 15.0, 4.0));
  }

  World& world_;
  Random& random_;
  Builder builder_;
};

}  // namespace

World MakeHighway(std::uint64_t seed, double length_m, double tunnel_m) {
  World world;
  world.name = "highway";
  world.length_m = length_m;
  world.drive_begin_m = kHighwayLeadIn;
  world.max_lateral_acceleration_mps2 = 3.0;

  Random route_random = MakeRandom(seed, Stream::kRoute);
  LayRoute(world, tunnel_m, route_random);

  Random random = MakeRandom(seed, Stream::kBuildings);
  Roadside roadside(world, random);
  roadside.AddBridges();
  for (const double side : {1.0, -1.0}) {
    roadside.AddRail(side * kInnerRail, 0.0, world.route.length_m(), 2.0);
    roadside.AddOuterRails(side);
    roadside.AddBarriersAndTrees(side);
    roadside.AddSignsAndDelineators(side);
    roadside.AddGantries(side);
  }
  BuildTunnel(world);

  world.ego_lane_offsets_m = {-kLanes[1], -kLanes[2]};
  for (const double lane : kLanes) {
    world.lanes.push_back({lane, -1, 30.0 - lane, 16.0});
    world.lanes.push_back({-lane, 1, 0.0, 14.0});
  }
  world.truck_share = 0.2;
  return world;
}

World MakeWorld(WorldKind kind, std::uint64_t seed, double length_m, double tunnel_m) {
  return kind == WorldKind::kTown ? MakeTown(seed, length_m, tunnel_m)
                                  : MakeHighway(seed, length_m, tunnel_m);
}

}  // namespace dcloc::simulation
