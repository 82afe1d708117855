#include "client/simulation/world/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>

#include "client/simulation/world/parking.h"
#include "client/simulation/world/steps.h"

namespace dcloc::simulation {
namespace {

double DistanceToWall(const Eigen::Vector2d& point, const Wall& wall) {
  const Eigen::Vector2d side = wall.end_m - wall.begin_m;
  const double share = (point - wall.begin_m).dot(side) / side.squaredNorm();
  return (wall.begin_m + std::clamp(share, 0.0, 1.0) * side - point).norm();
}

// Nothing stands in the lane that the drive takes, in either kind of world, for several seeds.
TEST(WorldTest, LeavesTheDrivesLaneFree) {
  for (const WorldKind kind : {WorldKind::kTown, WorldKind::kHighway}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const World world = MakeWorld(kind, seed, 500.0);
      for (const double s : Steps(0.0, world.route.length_m(), 2.0)) {
        for (const double lane : world.ego_lane_offsets_m) {
          const Eigen::Vector2d p = OffsetPoint(world.route, s, lane);
          for (const Wall& wall : world.walls) {
            ASSERT_GT(DistanceToWall(p, wall), 2.0) << world.name << " " << seed << " s " << s;
          }
          for (const Scatterer& scatterer : world.scatterers) {
            if (scatterer.position_m.z() < 0.1 || scatterer.position_m.z() > 4.5) continue;
            ASSERT_GT((scatterer.position_m.head<2>() - p).norm(), 1.5) << world.name << " s " << s;
          }
          for (const Pose2& slot : world.parking_slots) {
            ASSERT_GT((slot.translation_m - p).norm(), 2.0) << world.name << " s " << s;
          }
        }
      }
    }
  }
}

TEST(WorldTest, ReachesBeyondBothEndsOfTheDrive) {
  for (const WorldKind kind : {WorldKind::kTown, WorldKind::kHighway}) {
    const World world = MakeWorld(kind, 4, 1200.0);
    EXPECT_GT(world.drive_begin_m, 40.0);
    EXPECT_GT(world.route.length_m(), world.drive_begin_m + 1200.0 + 100.0);
    EXPECT_GT(world.scatterers.size(), 1500U);
  }
}

TEST(WorldTest, TheTownTurnsAndTheRouteDoesNotMeetItself) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const World world = MakeTown(seed, 1500.0);
    double most_turned = 0.0;
    std::vector<Eigen::Vector2d> points;
    for (const double s : Steps(0.0, world.route.length_m(), 5.0)) {
      points.push_back(world.route.At(s).position_m);
      most_turned = std::max(most_turned, std::abs(world.route.At(s).heading_rad));
    }
    EXPECT_GT(most_turned, 1.2);
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t j = i + 20; j < points.size(); ++j) {
        ASSERT_GT((points[i] - points[j]).norm(), 25.0) << "seed " << seed;
      }
    }
  }
}

TEST(WorldTest, DependsOnItsSeedAlone) {
  const auto positions = [](std::uint64_t seed) {
    std::vector<double> values;
    for (const Scatterer& scatterer : MakeTown(seed, 300.0).scatterers) {
      values.insert(values.end(), scatterer.position_m.begin(), scatterer.position_m.end());
    }
    return values;
  };
  EXPECT_EQ(positions(6), positions(6));
  EXPECT_NE(positions(6), positions(7));
}

// Where `p_map` is along a world's tunnel and to its left.
Eigen::Vector2d InTunnel(const World& world, const Eigen::Vector2d& p_map) {
  const PathPoint entry = world.route.At(world.tunnel->begin_m);
  return Pose2{entry.position_m, entry.heading_rad}.Inverse() * p_map;
}

TEST(TunnelTest, IsStraightInTheMiddleOfTheDriveAndEmpty) {
  for (const WorldKind kind : {WorldKind::kTown, WorldKind::kHighway}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const World world = MakeWorld(kind, seed, 900.0, 300.0);
      ASSERT_TRUE(world.tunnel.has_value());
      const Tunnel& tunnel = *world.tunnel;
      EXPECT_DOUBLE_EQ(tunnel.end_m - tunnel.begin_m, 300.0);
      EXPECT_GT(tunnel.begin_m, world.drive_begin_m + 200.0);
      EXPECT_LT(tunnel.end_m, world.drive_begin_m + 900.0 - 50.0);
      for (const double s : Steps(tunnel.begin_m, tunnel.end_m, 5.0)) {
        EXPECT_NEAR(InTunnel(world, world.route.At(s).position_m).y(), 0.0, 1e-9);
      }
      for (const Scatterer& scatterer : world.scatterers) {
        const Eigen::Vector2d p = InTunnel(world, scatterer.position_m.head<2>());
        EXPECT_FALSE(p.x() > 0.0 && p.x() < 300.0 && std::abs(p.y()) < tunnel.half_width_m)
            << world.name << " seed " << seed;
      }
      for (const Pose2& slot : world.parking_slots) {
        const Eigen::Vector2d p = InTunnel(world, slot.translation_m);
        EXPECT_FALSE(p.x() > 0.0 && p.x() < 300.0 && std::abs(p.y()) < tunnel.half_width_m);
      }
      for (const double lane : world.ego_lane_offsets_m) {
        EXPECT_LT(std::abs(lane), tunnel.half_width_m - 1.5);
      }
    }
  }
}

TEST(TunnelTest, ChangesNothingWhereThereIsNone) {
  const World plain = MakeTown(6, 900.0);
  EXPECT_FALSE(plain.tunnel.has_value());
  EXPECT_TRUE(std::ranges::all_of(plain.walls,
                                  [](const Wall& wall) { return wall.reflections_per_m == 0.0; }));
  // Up to the tunnel, the town is the same with it.
  const World bored = MakeTown(6, 900.0, 300.0);
  for (const double s : Steps(0.0, 50.0, 5.0)) {
    EXPECT_EQ(plain.route.At(s).position_m, bored.route.At(s).position_m);
  }
}

TEST(ParkingTest, AboutAFifthOfTheParkedVehiclesChanges) {
  const World world = MakeTown(8, 4000.0);
  const auto poses = [&](int pass) {
    std::map<std::size_t, Eigen::Vector2d> by_slot;
    for (const ParkedVehicle& parked : ParkVehicles(world, 8, pass, 0.2)) {
      by_slot[parked.slot] = parked.T_map_body.translation_m;
    }
    return by_slot;
  };
  const auto map = poses(0);
  ASSERT_GT(map.size(), 300U);
  const auto changed_share = [&](const std::map<std::size_t, Eigen::Vector2d>& live) {
    int changed = 0;
    for (const auto& [slot, position] : map) {
      if (!live.contains(slot) || live.at(slot) != position) ++changed;
    }
    return static_cast<double>(changed) / static_cast<double>(map.size());
  };
  EXPECT_EQ(changed_share(map), 0.0);
  EXPECT_NEAR(changed_share(poses(1)), 0.2, 0.06);
  EXPECT_NEAR(changed_share(poses(2)), 0.2, 0.06);
  EXPECT_NE(poses(1), poses(2));
  EXPECT_NEAR(static_cast<double>(poses(1).size()), static_cast<double>(map.size()),
              0.1 * static_cast<double>(map.size()));
}

TEST(WorldTest, ARingClosesAndNothingStandsOnIt) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const World world = MakeTownRing(seed, 3000.0, 1500.0);
    const double lap_m = world.route.length_m();
    EXPECT_NEAR(lap_m, 1500.0, 450.0) << seed;
    const PathPoint end = world.route.At(lap_m - 1e-9);
    const PathPoint start = world.route.At(0.0);
    EXPECT_LT((end.position_m - start.position_m).norm(), 1e-6) << seed;
    EXPECT_NEAR(end.heading_rad - start.heading_rad, 2.0 * std::numbers::pi, 1e-6) << seed;
    const PathPoint second_lap = world.route.At(lap_m + 100.0);
    EXPECT_LT((second_lap.position_m - world.route.At(100.0).position_m).norm(), 1e-6) << seed;
    for (const Wall& wall : world.walls) {
      const Eigen::Vector2d middle = 0.5 * (wall.begin_m + wall.end_m);
      for (const double s : Steps(0.0, lap_m, 2.0)) {
        ASSERT_GT((world.route.At(s).position_m - middle).norm(), 3.0) << seed << " at " << s;
      }
    }
  }
}

}  // namespace
}  // namespace dcloc::simulation
