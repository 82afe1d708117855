#include "core/update/new_streets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/passes/placed_landmark.h"
#include "core/update/map_update.h"
#include "tests/core/passes/street_fixture.h"

namespace dcloc {
namespace {

constexpr double kBeyond_m = TestStreet::kMappedEnd_m + 20.0;

/// A pass of the whole street of a vehicle that was tracked until `kBeyond_m`; from there on
/// odometry has it at `sideways` of the way beside where it is.
PlacedPass PassBeyond(const TestStreet& street, int day, const std::string& vehicle,
                      double sideways) {
  PlacedPass pass = street.Pass(day, vehicle);
  for (PlacedScan& scan : pass.scans) {
    const double beyond_m = scan.T_map_vehicle.translation_m.x() - kBeyond_m;
    if (beyond_m <= 0.0) continue;
    scan.is_beyond_map = true;
    scan.T_map_vehicle = scan.T_map_vehicle * Embed(Pose2{{0.0, sideways * beyond_m}, 0.0});
    scan.T_start_vehicle = Flatten(scan.T_map_vehicle);
  }
  return pass;
}

double EndOf(const EditableMap& map) {
  double end_m = 0.0;
  for (const EditableKeyframe& keyframe : map.keyframes) {
    end_m = std::max(end_m, PoseOf(keyframe.record).translation_m.x() + map.Origin_m().x());
  }
  return end_m;
}

TEST(NewStreetsTest, AStreetThatTwoVehiclesDroveJoins) {
  const TestStreet street;
  const EditableMap base = street.MapOfPart();
  const std::vector<PlacedPass> passes = {PassBeyond(street, 1, "a", 0.005),
                                          PassBeyond(street, 2, "b", -0.005)};
  const auto update = UpdateMap(base, passes);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_NEAR(update->new_streets.joined_m, TestStreet::kLength_m - kBeyond_m, 20.0);
  EXPECT_EQ(update->new_streets.unproven_m, 0.0);
  EXPECT_EQ(update->map.keyframes.size(),
            base.keyframes.size() + update->new_streets.T_local_keyframes.size());
  EXPECT_GT(EndOf(update->map), TestStreet::kLength_m - 15.0);
  std::size_t found = 0;
  std::size_t all = 0;
  for (const Eigen::Vector2d& p_m : street.scatterers_m) {
    if (p_m.x() < kBeyond_m + 10.0 || p_m.x() > TestStreet::kLength_m - 10.0) continue;
    double nearest_m = INFINITY;
    for (const PlacedLandmark& landmark : LandmarksOf(update->map)) {
      const Eigen::Vector2d at_m = landmark.position.position_m + base.Origin_m().head<2>();
      nearest_m = std::min(nearest_m, (at_m - p_m).norm());
    }
    ++all;
    found += nearest_m < 0.3 ? 1 : 0;
  }
  EXPECT_GE(10 * found, 9 * all) << found << " of " << all;
}

TEST(NewStreetsTest, OneThatOneVehicleDroveOnOneDayDoesNot) {
  const TestStreet street;
  const EditableMap base = street.MapOfPart();
  std::vector<PlacedPass> passes = {PassBeyond(street, 1, "a", 0.0), street.Pass(2, "b")};
  std::erase_if(passes[1].scans, [](const PlacedScan& scan) {
    return scan.T_map_vehicle.translation_m.x() > TestStreet::kMappedEnd_m;
  });
  const auto update = UpdateMap(base, passes);
  ASSERT_TRUE(update.ok()) << update.status();
  EXPECT_EQ(update->new_streets.joined_m, 0.0);
  EXPECT_NEAR(update->new_streets.unproven_m, TestStreet::kLength_m - kBeyond_m, 20.0);
  EXPECT_EQ(update->map.keyframes.size(), base.keyframes.size());
}

}  // namespace
}  // namespace dcloc
