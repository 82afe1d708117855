#include "core/passes/beyond_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/passes/street_fixture.h"

namespace dcloc {
namespace {

/// A pass of the whole street: tracked on the map's part of it, and not behind it, where nothing is
/// known of its pose.
PlacedPass LeavingPass(const TestStreet& street) {
  PlacedPass pass = street.Pass(1, "a");
  for (PlacedScan& scan : pass.scans) {
    if (scan.T_map_vehicle.translation_m.x() <= TestStreet::kMappedEnd_m) continue;
    scan.is_good = false;
    scan.T_map_vehicle = Pose3();
  }
  return pass;
}

std::shared_ptr<const RadarMap> PartOf(const TestStreet& street) {
  return RadarMap::FromBytes(ToMapBytes(street.MapOfPart()).value()).value();
}

TEST(BeyondMapTest, ScansBehindTheMapAreWhereOdometryHasThem) {
  const TestStreet street;
  PlacedPass pass = LeavingPass(street);
  PlaceBeyondMap(*PartOf(street), {}, pass);
  const std::size_t tracked = pass.GoodCount();
  EXPECT_EQ(tracked, static_cast<std::size_t>(TestStreet::kMappedEnd_m) + 1);
  EXPECT_NEAR(static_cast<double>(pass.BeyondCount()), 85.0, 12.0);
  for (const PlacedScan& scan : pass.scans) {
    if (!scan.is_beyond_map) continue;
    const double x_m = scan.T_start_vehicle.translation_m.x();
    EXPECT_NEAR(scan.T_map_vehicle.translation_m.x(), x_m, 1e-3);
    EXPECT_GT(x_m, TestStreet::kMappedEnd_m);
    EXPECT_FALSE(scan.points.empty());
  }
}

TEST(BeyondMapTest, ScansThatWereLostOnTheMapDoNotCount) {
  const TestStreet street;
  PlacedPass pass = LeavingPass(street);
  for (std::size_t i = 40; i < 60; ++i) pass.scans[i].is_good = false;
  PlaceBeyondMap(*PartOf(street), {}, pass);
  for (std::size_t i = 40; i < 60; ++i) {
    EXPECT_FALSE(pass.scans[i].is_good) << i;
    EXPECT_TRUE(pass.scans[i].points.empty()) << i;
  }
}

TEST(BeyondMapTest, NothingIsPlacedByOdometryForEver) {
  const TestStreet street;
  PlacedPass pass = LeavingPass(street);
  PlaceBeyondMap(*PartOf(street), {.max_way_m = 50.0}, pass);
  ASSERT_GT(pass.BeyondCount(), 0U);
  for (const PlacedScan& scan : pass.scans) {
    if (!scan.is_good) continue;
    EXPECT_LE(scan.T_start_vehicle.translation_m.x(), TestStreet::kMappedEnd_m + 50.5);
  }
}

TEST(BeyondMapTest, APassThatWasHardlyTrackedIsTiedToNothing) {
  const TestStreet street;
  PlacedPass pass = LeavingPass(street);
  for (std::size_t i = 20; i < pass.scans.size(); ++i) pass.scans[i].is_good = false;
  PlaceBeyondMap(*PartOf(street), {}, pass);
  EXPECT_EQ(pass.BeyondCount(), 0U);
}

}  // namespace
}  // namespace dcloc
