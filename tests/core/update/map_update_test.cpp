#include "core/update/map_update.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include "core/passes/placed_landmark.h"
#include "tests/core/passes/street_fixture.h"

namespace dcloc {
namespace {

double NearestLandmark_m(const EditableMap& map, const Eigen::Vector2d& p_map_m) {
  double nearest_m = INFINITY;
  for (const PlacedLandmark& landmark : LandmarksOf(map)) {
    const Eigen::Vector2d p_m = landmark.position.position_m + map.Origin_m().head<2>();
    nearest_m = std::min(nearest_m, (p_m - p_map_m).norm());
  }
  return nearest_m;
}

std::vector<PlacedPass> ThreePasses(const TestStreet& street) {
  return {street.Pass(1, "a"), street.Pass(2, "b"), street.Pass(3, "a")};
}

TEST(MapUpdateTest, AStreetThatStaysAsItWasStays) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  const auto update = UpdateMap(base, ThreePasses(street));
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_EQ(update->map.PointCount(), base.PointCount());
  for (const LandmarkHistory& landmark : update->known) {
    EXPECT_EQ(landmark.fate, LandmarkFate::kKept);
  }
}

TEST(MapUpdateTest, WhatManyPassesSawLiesNearerToWhereItStands) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  const auto update = UpdateMap(base, ThreePasses(street));
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_GT(update->refined_count, base.PointCount() / 2);
  const auto sum_m = [&](const EditableMap& map) {
    double sum = 0.0;
    for (const Eigen::Vector2d& p_m : street.scatterers_m) {
      sum += std::min(0.5, NearestLandmark_m(map, p_m));
    }
    return sum;
  };
  EXPECT_LT(sum_m(update->map), 0.9 * sum_m(base));
}

TEST(MapUpdateTest, PosesThatLieToOneSideDoNotMoveTheMap) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  const Eigen::Vector3d ahead_m(0.06, 0.0, 0.0);
  const std::vector<PlacedPass> passes = {
      street.Pass(1, "a", ahead_m), street.Pass(2, "b", ahead_m), street.Pass(3, "a", ahead_m)};
  const auto update = UpdateMap(base, passes);
  ASSERT_TRUE(update.ok()) << update.status();
  double mean_m = 0.0;
  double count = 0.0;
  for (const PlacedLandmark& landmark : LandmarksOf(update->map)) {
    const Eigen::Vector2d p_m = landmark.position.position_m + base.Origin_m().head<2>();
    for (const Eigen::Vector2d& scatterer_m : street.scatterers_m) {
      if ((p_m - scatterer_m).norm() > 0.5) continue;
      mean_m += p_m.x() - scatterer_m.x();
      count += 1.0;
    }
  }
  EXPECT_LT(std::abs(mean_m / count), 0.02);
}

TEST(MapUpdateTest, WhatWentGoesAndWhatCameComes) {
  TestStreet street;
  const EditableMap base = street.Map(0);
  const Eigen::Vector2d removed_m = street.scatterers_m[30];
  const Eigen::Vector2d added_m(removed_m.x() + 2.0, 9.0);
  street.scatterers_m[30] = added_m;
  ASSERT_LT(NearestLandmark_m(base, removed_m), 0.2);
  const auto update = UpdateMap(base, ThreePasses(street));
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_GT(NearestLandmark_m(update->map, removed_m), 1.0);
  EXPECT_LT(NearestLandmark_m(update->map, added_m), 0.2);
  EXPECT_EQ(std::ranges::count(update->known, LandmarkFate::kRemoved, &LandmarkHistory::fate), 1);
  EXPECT_EQ(std::ranges::count(update->found, LandmarkFate::kAdded, &LandmarkHistory::fate), 1);
}

TEST(MapUpdateTest, WhatOnlyOneDaySawDoesNotCome) {
  const TestStreet street;
  TestStreet with_car = street;
  const Eigen::Vector2d car_m(101.0, 2.5);
  with_car.scatterers_m.push_back(car_m);
  const std::vector<PlacedPass> passes = {street.Pass(1, "a"), with_car.Pass(2, "b"),
                                          street.Pass(3, "a")};
  const auto update = UpdateMap(street.Map(0), passes);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_GT(NearestLandmark_m(update->map, car_m), 1.0);
}

/// `street` with vehicles at the kerb, in about every other slot, other ones each day.
TestStreet WithParked(TestStreet street, int day) {
  std::mt19937 random(static_cast<std::uint32_t>(day));
  std::uniform_real_distribution<double> chance;
  for (int slot = 0; 6.0 * slot < TestStreet::kLength_m; ++slot) {
    const bool is_taken = chance(random) < 0.6;
    const double along_m = 6.0 * slot + 0.5 * (chance(random) - 0.5);
    if (is_taken) street.scatterers_m.emplace_back(along_m, 3.0);
  }
  return street;
}

std::ptrdiff_t CountInRow(const EditableMap& map, double offset_m) {
  return std::ranges::count_if(LandmarksOf(map), [&](const PlacedLandmark& landmark) {
    const double y_m = landmark.position.position_m.y() + map.Origin_m().y();
    return std::abs(y_m - offset_m) < 0.8;
  });
}

TEST(MapUpdateTest, WhereVehiclesParkLittleStaysInTheMap) {
  const TestStreet street;
  const EditableMap base = WithParked(street, 0).Map(0);
  const std::vector<PlacedPass> passes = {WithParked(street, 1).Pass(1, "a"),
                                          WithParked(street, 2).Pass(2, "b"),
                                          WithParked(street, 3).Pass(3, "c")};
  const auto update = UpdateMap(base, passes);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_GT(CountInRow(base, 3.0), 12);
  EXPECT_LT(CountInRow(update->map, 3.0), CountInRow(base, 3.0) / 2);
  EXPECT_EQ(CountInRow(update->map, 6.0), CountInRow(base, 6.0));
  EXPECT_EQ(CountInRow(update->map, -7.0), CountInRow(base, -7.0));
}

TEST(MapUpdateTest, AVehicleThatMissesARowDoesNotTakeItOut) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  TestStreet blind = street;
  std::erase_if(blind.scatterers_m, [](const Eigen::Vector2d& p_m) { return p_m.y() > 0.0; });
  const std::vector<PlacedPass> passes = {street.Pass(1, "a"), street.Pass(2, "b"),
                                          blind.Pass(3, "c")};
  const auto update = UpdateMap(base, passes);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_EQ(CountInRow(update->map, 6.0), CountInRow(base, 6.0));
}

TEST(MapUpdateTest, OneVehicleOnOneDayChangesNothing) {
  TestStreet street;
  const EditableMap base = street.Map(0);
  street.scatterers_m[30] += Eigen::Vector2d(2.0, 3.0);
  PlacedPass again = street.Pass(1, "a");
  for (PlacedScan& scan : again.scans) scan.stamp += std::chrono::minutes(30);
  const auto update = UpdateMap(base, std::vector<PlacedPass>{street.Pass(1, "a"), again});
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_EQ(ToMapBytes(update->map).value(), ToMapBytes(base).value());
}

TEST(MapUpdateTest, AVehicleThatIsPlacedWrongDoesNotBendTheMap) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  const std::vector<PlacedPass> passes = {street.Pass(1, "a"), street.Pass(2, "b"),
                                          street.Pass(3, "c", {0.6, 0.4, 0.0})};
  const auto update = UpdateMap(base, passes);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_EQ(update->map.PointCount(), base.PointCount());
  for (const Eigen::Vector2d& p_m : street.scatterers_m) {
    if (NearestLandmark_m(base, p_m) > 0.2) continue;
    EXPECT_LT(NearestLandmark_m(update->map, p_m), 0.2);
  }
}

TEST(MapUpdateTest, RefusesPassesOfWhichNoScanCounts) {
  const TestStreet street;
  PlacedPass pass = street.Pass(1, "a");
  for (PlacedScan& scan : pass.scans) scan.is_good = false;
  EXPECT_EQ(UpdateMap(street.Map(0), {&pass, 1}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc
