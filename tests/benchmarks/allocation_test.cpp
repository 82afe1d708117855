// A tracker's scan allocates nothing.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <memory>
#include <random>
#include <vector>

#include "core/localizer/localizer.h"
#include "core/registration/gicp.h"
#include "tests/benchmarks/allocations.h"
#include "tests/core/localizer/synthetic_world.h"

namespace dcloc::benchmarks {
namespace {

TEST(AllocationTest, TheCounterCounts) {
  const std::int64_t before = AllocationCount();
  const auto block = std::make_unique<std::array<double, 100>>();
  EXPECT_EQ(AllocationCount() - before, 1);
  EXPECT_NE(block, nullptr);
}

TEST(AllocationTest, RegistrationWithMemoryOfItsOwnAllocatesNothing) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place_m(-50.0, 50.0);
  std::vector<GaussianPoint<2>> points;
  points.reserve(1000);
  for (int i = 0; i < 1000; ++i) {
    points.push_back({{place_m(random), place_m(random)}, 0.04 * Eigen::Matrix2d::Identity()});
  }
  const LocalMap<2> map({}, points);
  const Pose2 start{.translation_m = {0.1, -0.05}, .yaw_rad = 0.002};
  CorrespondenceFinder<2> finder;
  RegisterGicp<2>(points, map, start, {}, finder);
  const std::int64_t before = AllocationCount();
  const auto registration = RegisterGicp<2>(points, map, start, {}, finder);
  EXPECT_EQ(AllocationCount() - before, 0);
  EXPECT_TRUE(registration.converged);
}

// Ahead along a road and backwards to where it began: what comes again, lap after lap, needs no
// more memory than before.
std::vector<TrueScan> Lap(const SyntheticWorld& world, const Rig& rig) {
  constexpr double kSpeed_mps = 12.0;
  constexpr int kScans = 100;  // with the way back a multiple of a window's scans
  constexpr double kInterval_s = 0.077;
  std::mt19937 random(12);
  std::vector<TrueScan> lap;
  for (int i = 0; i < 2 * kScans; ++i) {
    const bool ahead = i < kScans;
    const EgoVelocity ego = SyntheticWorld::VelocityAt(ahead ? kSpeed_mps : -kSpeed_mps);
    const int place = ahead ? i : 2 * kScans - 1 - i;
    const Pose3 T_map_vehicle = SyntheticWorld::OnRoad(kSpeed_mps * kInterval_s * place);
    const Stamp stamp(std::chrono::milliseconds(77 * i));
    Scan scan = world.See(rig.radars[0], T_map_vehicle, ego, stamp, random);
    scan.ego_velocity = ego;
    lap.push_back({std::move(scan), T_map_vehicle});
  }
  return lap;
}

// With everything that a scan does, from one local map to the next.
void ExpectNoAllocationWhileTracking(const Rig& rig, double height_m) {
  const SyntheticWorld world(height_m);
  const auto map = MapOfDrive(DriveRoad(world, rig, 18.0, 11), rig);
  std::vector<TrueScan> lap = Lap(world, rig);
  Localizer localizer = MakeLocalizer(map, rig, PriorAt(lap.front().T_map_vehicle, 0.2, 0.01));
  const std::chrono::milliseconds duration(77 * static_cast<std::int64_t>(lap.size()));
  constexpr int kLaps = 4;
  for (int number = 0; number < kLaps; ++number) {
    const bool grown = number == kLaps - 1;
    for (std::size_t i = 0; i < lap.size(); ++i) {
      const std::int64_t before = AllocationCount();
      const auto answer = localizer.Localize(lap[i].scan);
      const std::int64_t count = AllocationCount() - before;
      ASSERT_TRUE(answer.ok()) << answer.status();
      lap[i].scan.stamp += duration;
      if (!grown) continue;
      EXPECT_EQ(count, 0) << "scan " << i;
      EXPECT_EQ(answer->state, LocalizationState::kTracking);
      EXPECT_TRUE(answer->quality.is_accepted) << "scan " << i;
    }
  }
}

TEST(AllocationTest, ATrackedScanInThePlaneAllocatesNothing) {
  ExpectNoAllocationWhileTracking(FrontRadar(), 0.0);
}

TEST(AllocationTest, ATrackedScanInSpaceAllocatesNothing) {
  ExpectNoAllocationWhileTracking(FrontRadar(0.0, /*has_elevation=*/true), 4.0);
}

}  // namespace
}  // namespace dcloc::benchmarks
