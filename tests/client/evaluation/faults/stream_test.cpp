#include "client/evaluation/faults/stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "client/evaluation/faults/fault_list.h"
#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

TEST(StreamTest, IsTheDriveAsItIs) {
  const Drive drive = MadeDrive(1.0, 2);
  const Stream stream = MadeStream(1.0, 2);
  ASSERT_EQ(stream.scans.size(), 20U);
  EXPECT_EQ(stream.scans[3].scan.stamp, drive.scans[3].scan.stamp);
  EXPECT_EQ(stream.scans[3].measured, stream.scans[3].scan.stamp);
  EXPECT_EQ(stream.scans[3].arrived, stream.scans[3].scan.stamp);
}

TEST(StreamTest, ReversingIsTheSameWayBackwards) {
  Drive drive = MadeDrive(1.0);
  drive.rig.radars[0].beta_s = 0.04;
  const Drive reversed = Reversed(drive);
  ASSERT_EQ(reversed.scans.size(), 10U);
  EXPECT_EQ(reversed.scans[0].scan.stamp, drive.scans[0].scan.stamp);
  EXPECT_EQ(reversed.scans[9].scan.stamp, drive.scans[9].scan.stamp);
  EXPECT_NEAR(reversed.scans[0].T_map_vehicle.translation_m.x(), 9.0, 1e-9);
  const Scan& scan = reversed.scans[9].scan;
  EXPECT_NEAR(scan.ego_velocity->linear_mps.x(), -10.0, 1e-9);
  EXPECT_EQ(scan.range_rate_mps[0], 9.0F);
  // 20 m was shown for 20.36 m: now it shows 20.72 m.
  EXPECT_NEAR(scan.range_m[0], 20.72F, 1e-4F);
}

TEST(CatalogueTest, FaultsHaveNamesOfTheirOwnAndChangeADrive) {
  std::set<std::string> ids;
  for (const Fault& fault : AllFaults(false)) {
    EXPECT_TRUE(ids.insert(fault.id).second) << fault.id;
    EXPECT_EQ(fault.id.substr(0, fault.family.size()), fault.family);
    Stream stream = MadeStream(32.0, 2);
    stream.map = MadeMap(33);
    float range_m = 10.0F;  // no scan is like another
    for (StreamScan& entry : stream.scans) entry.scan.range_m[0] = range_m += 0.01F;
    const Stream before = stream;
    fault.apply(stream, WindowOf(fault, stream), 1);
    bool is_same =
        stream.scans.size() == before.scans.size() && stream.map == before.map &&
        stream.prior.T_map_vehicle.translation_m == before.prior.T_map_vehicle.translation_m &&
        stream.prior.T_map_vehicle.rotation.coeffs() ==
            before.prior.T_map_vehicle.rotation.coeffs() &&
        stream.rig.radars[0].T_vehicle_radar.rotation.coeffs() ==
            before.rig.radars[0].T_vehicle_radar.rotation.coeffs();
    for (std::size_t i = 0; is_same && i < before.scans.size(); ++i) {
      const Scan &was = before.scans[i].scan, &is = stream.scans[i].scan;
      const auto& velocity = is.ego_velocity;
      is_same = was.stamp == is.stamp && was.radar_id == is.radar_id && was.range_m == is.range_m &&
                was.azimuth_rad == is.azimuth_rad && was.range_rate_mps == is.range_rate_mps &&
                was.range_sigma_m == is.range_sigma_m && velocity && !velocity->covariance &&
                velocity->linear_mps == was.ego_velocity->linear_mps &&
                velocity->angular_radps == was.ego_velocity->angular_radps;
    }
    // Only who reverses has a speed whose sign can be lost.
    EXPECT_EQ(is_same, fault.is_reversing) << fault.id;
  }
  EXPECT_GE(ids.size(), 50U);
  EXPECT_EQ(AllFaults(true).size(), 5U);
}

TEST(CatalogueTest, SelectsFaultsAndWorldsByName) {
  const Selection all{AllFaults(false), SimulatedWorlds(1, false)};
  EXPECT_EQ(Select(all, {})->faults.size(), all.faults.size());
  const auto both = Select(all, {"movers", "velocity-sign", "tunnel"});
  ASSERT_TRUE(both.ok());
  EXPECT_EQ(both->faults.size(), 5U);
  EXPECT_EQ(both->worlds.size(), 3U);
  EXPECT_EQ(Select(all, {"town-2"})->worlds.size(), 1U);
  const auto unknown = Select(all, {"movers", "moon"});
  EXPECT_EQ(unknown.status().code(), absl::StatusCode::kInvalidArgument);
  const std::string message(unknown.status().message());
  EXPECT_EQ(message.find("only is 'moon'; it must be one of town, "), 0U) << message;
}

TEST(WorldsTest, NoTwoSeedsShareAWorld) {
  std::set<std::uint64_t> seeds;
  std::set<std::string> names;
  for (const std::uint64_t seed : {1U, 2U}) {
    for (const World& world : SimulatedWorlds(seed, false)) {
      EXPECT_TRUE(seeds.insert(world.seed).second) << world.name;
      names.insert(world.name);
    }
  }
  EXPECT_EQ(seeds.size(), 36U);
  EXPECT_EQ(names.size(), 18U);
}

}  // namespace
}  // namespace dcloc::faults
