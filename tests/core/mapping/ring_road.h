#pragma once

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/radar/scan.h"
#include "tests/core/localizer/synthetic_world.h"

namespace dcloc {

inline constexpr double kRingRadius_m = 90.0;
/// Of the drives' gyroscope, so that the trajectory by ego-motion does not close.
inline constexpr double kYawRateBias_radps = 0.002;

/// A ring road between scatterers at random places.
inline SyntheticWorld RingRoad(unsigned seed) {
  SyntheticWorld world;
  world.scatterers_m.clear();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi);
  std::uniform_real_distribution<double> aside_m(3.0, 20.0);
  for (int i = 0; i < 900; ++i) {
    const double radius_m = kRingRadius_m + (i % 2 == 0 ? 1.0 : -1.0) * aside_m(random);
    const double at = angle(random);
    world.scatterers_m.emplace_back(radius_m * std::cos(at), radius_m * std::sin(at), 0.0);
  }
  return world;
}

inline Pose3 OnRing(double along_m) {
  const double angle = along_m / kRingRadius_m;
  return Embed(
      Pose2{.translation_m = {kRingRadius_m * std::cos(angle), kRingRadius_m * std::sin(angle)},
            .yaw_rad = WrapAngle(angle + 0.5 * std::numbers::pi)});
}

/// A scan of a drive on the ring, and where it was taken.
struct RingScan {
  Scan scan;
  Pose3 T_map_vehicle;
};

/// Those of a drive of `FrontRadar`; drives of different seeds are hours apart.
inline std::vector<RingScan> ScansOnRing(const SyntheticWorld& world, double begin_m,
                                         double length_m, double speed_mps, unsigned seed) {
  const Rig rig = FrontRadar();
  std::mt19937 random(seed);
  std::vector<RingScan> scans;
  for (int i = 0; 0.077 * i * speed_mps < length_m; ++i) {
    const Stamp stamp(std::chrono::seconds(1'700'000'000 + 10'000 * seed) +
                      std::chrono::milliseconds(77 * i));
    const Pose3 T_map_vehicle = OnRing(begin_m + 0.077 * i * speed_mps);
    EgoVelocity ego{.linear_mps = {speed_mps, 0.0, 0.0},
                    .angular_radps = {0.0, 0.0, speed_mps / kRingRadius_m}};
    Scan scan = world.See(rig.radars[0], T_map_vehicle, ego, stamp, random);
    ego.angular_radps.z() += kYawRateBias_radps;
    scan.ego_velocity = ego;
    scans.push_back({std::move(scan), T_map_vehicle});
  }
  return scans;
}

}  // namespace dcloc
