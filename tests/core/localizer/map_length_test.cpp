#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <limits>

#include "tests/core/localizer/synthetic_world.h"
#include "tests/core/map/synthetic_map.h"

namespace dcloc {
namespace {

constexpr std::size_t kShortMap = 100;   // keyframes 10 m apart: 1 km
constexpr std::size_t kLongMap = 5'000;  // 50 km, of which the first is the short one

std::shared_ptr<const RadarMap> SpiralOf(std::size_t keyframe_count) {
  constexpr std::uint32_t kPointsPerKeyframe = 40;
  SyntheticMap parts(keyframe_count, kPointsPerKeyframe);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place_m(-20.0F, 20.0F);
  for (MapPoint& point : parts.points) {
    point.x_m = place_m(random);
    point.y_m = place_m(random);
    point.z_m = 0.0F;
    point.xx_m2 = point.yy_m2 = 0.01F;
    point.xy_m2 = 0.0F;
  }
  auto map = RadarMap::FromBytes(parts.Bytes());
  EXPECT_TRUE(map.ok()) << map.status();
  return *std::move(map);
}

// A drive along the first keyframes, 10 m/s; the scans hold the map's own points.
std::vector<TrueScan> DriveAlong(const RadarMap& map, int scan_count) {
  const RadarModel radar = FrontRadar().radars[0];
  SyntheticWorld world;
  world.scatterers_m.clear();
  for (std::size_t i = 0; i < 30; ++i) {
    const Keyframe keyframe = map.keyframe(i);
    for (const MapPoint& point : keyframe.points) {
      world.scatterers_m.push_back(keyframe.T_map_keyframe *
                                   Eigen::Vector3d(point.x_m, point.y_m, point.z_m));
    }
  }
  std::vector<TrueScan> drive;
  std::mt19937 random(4);
  for (int i = 0; i < scan_count; ++i) {
    const double at = 5.0 + 0.05 * i;
    const auto keyframe = static_cast<std::size_t>(at);
    const Pose3 T_map_from = map.keyframe(keyframe).T_map_keyframe;
    const Vector6d step = Log(T_map_from.Inverse() * map.keyframe(keyframe + 1).T_map_keyframe);
    const Pose3 T_map_vehicle =
        T_map_from * Exp(Vector6d(step * (at - static_cast<double>(keyframe))));
    const EgoVelocity ego{.linear_mps = step.head<3>(), .angular_radps = step.tail<3>()};
    const Stamp stamp(std::chrono::seconds(1000) + std::chrono::milliseconds(50 * i));
    Scan scan = world.See(radar, T_map_vehicle, ego, stamp, random);
    scan.ego_velocity = ego;
    drive.push_back({std::move(scan), T_map_vehicle});
  }
  return drive;
}

// This thread's own time, so that a busy machine changes little.
double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

TEST(MapLengthTest, AScanCostsTheSameInFiftyTimesTheMap) {
  const auto short_map = SpiralOf(kShortMap);
  const auto long_map = SpiralOf(kLongMap);
  ASSERT_NEAR(long_map->info().length_m, 50.0 * short_map->info().length_m, 1e-6);
  const std::vector<TrueScan> drive = DriveAlong(*short_map, 60);

  double best_short_s = std::numeric_limits<double>::infinity();
  double best_long_s = std::numeric_limits<double>::infinity();
  for (int run = 0; run < 3; ++run) {
    for (const bool is_long : {false, true}) {
      const auto& map = is_long ? long_map : short_map;
      Localizer localizer =
          MakeLocalizer(map, FrontRadar(), PriorAt(drive.front().T_map_vehicle, 0.2, 0.01));
      const double begin_s = CpuSeconds();
      const auto answers = LocalizeDrive(std::move(localizer), drive);
      double& best_s = is_long ? best_long_s : best_short_s;
      best_s = std::min(best_s, CpuSeconds() - begin_s);
      EXPECT_TRUE(answers.back().tracking());
      EXPECT_LT(answers.back().position_error_m(), 0.3);
    }
  }
  RecordProperty("long_over_short", std::to_string(best_long_s / best_short_s));
  EXPECT_LT(best_long_s, 2.0 * best_short_s);
}

TEST(MapLengthTest, WhatLiesFarAwayChangesNoBit) {
  const auto short_map = SpiralOf(kShortMap);
  const auto long_map = SpiralOf(kLongMap);
  const std::vector<TrueScan> drive = DriveAlong(*short_map, 40);
  const InitialPose prior = PriorAt(drive.front().T_map_vehicle, 0.5, 0.03);
  const auto a = LocalizeDrive(MakeLocalizer(short_map, FrontRadar(), prior), drive);
  const auto b = LocalizeDrive(MakeLocalizer(long_map, FrontRadar(), prior), drive);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ExpectSame(a[i].localization, b[i].localization);
}

}  // namespace
}  // namespace dcloc
