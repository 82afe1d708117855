#include "core/passes/placed_pass.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

SimulationOptions TownOf(std::uint64_t seed) {
  SimulationOptions options;
  options.seed = seed;
  options.length_m = 200.0;
  return options;
}

Drive DriveOf(const SimulationOptions& options, std::size_t pass) {
  return SimulatePass(options, Passes(options)[pass]).value();
}

std::shared_ptr<const RadarMap> MapOfTown(std::uint64_t seed) {
  return RadarMap::FromBytes(BuildMap(DriveOf(TownOf(seed), 0), {.name = "town"}).value()).value();
}

PlacedPass PlaceIn(const std::shared_ptr<const RadarMap>& map, const Drive& drive,
                   std::size_t scan_count) {
  auto placer = PassPlacer::Create(map, drive.name, "a", drive.rig).value();
  for (std::size_t i = 0; i < std::min(scan_count, drive.scans.size()); ++i) {
    placer.Add(drive.scans[i].scan);
  }
  return std::move(placer).Finish();
}

TEST(PassPlacerTest, ScansThatCountLieWhereTheVehicleWas) {
  const Drive drive = DriveOf(TownOf(3), 1);
  const PlacedPass pass = PlaceIn(MapOfTown(3), drive, drive.scans.size());
  EXPECT_EQ(FaultOf(pass), "");
  ASSERT_EQ(pass.scans.size(), drive.scans.size());
  EXPECT_GT(pass.GoodCount(), drive.scans.size() / 2);
  for (std::size_t i = 0; i < pass.scans.size(); ++i) {
    if (!pass.scans[i].is_good) continue;
    const Eigen::Vector3d error_m =
        pass.scans[i].T_map_vehicle.translation_m - drive.scans[i].T_map_vehicle.translation_m;
    EXPECT_LT(error_m.head<2>().norm(), 0.3) << i;
    EXPECT_FALSE(pass.scans[i].points.empty()) << i;
  }
}

TEST(PassPlacerTest, ADriveOfAnotherPlaceIsOfNoUse) {
  const Drive drive = DriveOf(TownOf(4), 1);
  const PlacedPass pass = PlaceIn(MapOfTown(3), drive, drive.scans.size());
  EXPECT_THAT(FaultOf(pass), HasSubstr("it is not tracked in the map; it lies elsewhere"));
}

TEST(PassPlacerTest, ADriveThatHardlyMovedIsOfNoUse) {
  const PlacedPass pass = PlaceIn(MapOfTown(3), DriveOf(TownOf(3), 1), 10);
  EXPECT_THAT(FaultOf(pass), HasSubstr("it moved"));
}

TEST(PassPlacerTest, StampsThatGoBackAreNamed) {
  Drive drive = DriveOf(TownOf(3), 1);
  for (std::size_t i = 50; i < drive.scans.size(); i += 2) {
    drive.scans[i].scan.stamp -= std::chrono::hours(1);
  }
  const PlacedPass pass = PlaceIn(MapOfTown(3), drive, drive.scans.size());
  EXPECT_THAT(FaultOf(pass), HasSubstr("scans were refused"));
}

}  // namespace
}  // namespace dcloc
