// A tracker's scan allocates next to nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
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
  MatchFinder<2> finder;
  RegisterGicp<2>(points, map, start, {}, finder);
  const std::int64_t before = AllocationCount();
  const auto registration = RegisterGicp<2>(points, map, start, {}, finder);
  EXPECT_EQ(AllocationCount() - before, 0);
  EXPECT_TRUE(registration.converged);
}

TEST(AllocationTest, ATrackedScanAllocatesLittle) {
  const Rig rig = FrontRadar();
  const SyntheticWorld world;
  const auto map = MapOfDrive(DriveRoad(world, rig, 18.0, 11), rig);
  const auto drive = DriveRoad(world, rig, 12.0, 12);
  Localizer localizer = MakeLocalizer(map, rig, PriorAt(drive.front().T_map_vehicle, 0.2, 0.01));
  std::vector<std::int64_t> counts;
  for (const TrueScan& seen : drive) {
    const std::int64_t before = AllocationCount();
    const auto answer = localizer.Localize(seen.scan);
    const std::int64_t count = AllocationCount() - before;
    ASSERT_TRUE(answer.ok());
    if (answer->state == LocalizationState::kTracking) counts.push_back(count);
  }
  ASSERT_GT(counts.size(), 50U);
  const auto median = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2);
  std::ranges::nth_element(counts, median);
  RecordProperty("median", static_cast<int>(*median));
  // Nearly all of them are Ceres's, for the pose graph.
  EXPECT_LT(*median, 450);
}

}  // namespace
}  // namespace dcloc::benchmarks
