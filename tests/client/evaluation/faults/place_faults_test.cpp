#include "client/evaluation/faults/place_faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/geometry/degrees.h"
#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

TEST(PlaceFaultsTest, AStretchIsMissingAndTheClockHasNotGoneOn) {
  Stream stream = MadeStream(10.0);  // 1 m a scan
  CarryAhead(stream, MadeStamp(5.0), 20.0);
  ASSERT_EQ(stream.scans.size(), 80U);
  const StreamScan& before = stream.scans[49];
  const StreamScan& after = stream.scans[50];
  EXPECT_EQ(before.measured, MadeStamp(4.9));
  EXPECT_NEAR(after.T_map_vehicle.translation_m.x(), 70.0, 1e-9);
  EXPECT_EQ(after.measured, MadeStamp(5.0));
  EXPECT_EQ(after.scan.stamp, after.measured);
  EXPECT_EQ(after.arrived, after.measured);
  EXPECT_EQ(stream.scans.back().scan.stamp, MadeStamp(7.9));
  EXPECT_TRUE(std::ranges::is_sorted(stream.scans, {}, &StreamScan::measured));
}

TEST(PlaceFaultsTest, AStretchBeyondTheDriveEndsIt) {
  Stream stream = MadeStream(10.0);
  CarryAhead(stream, MadeStamp(5.0), 200.0);
  EXPECT_EQ(stream.scans.size(), 50U);
  CarryAhead(stream, MadeStamp(8.0), 20.0);  // nothing is there
  EXPECT_EQ(stream.scans.size(), 50U);
}

TEST(PlaceFaultsTest, APriorIsWrongAndSure) {
  for (const Fault& fault : PlaceFaults()) {
    if (fault.id.find("prior") == std::string::npos) continue;
    Stream stream = MadeStream(10.0);
    fault.apply(stream, WindowOf(fault, stream), 5);
    EXPECT_EQ(stream.scans.size(), 100U) << fault.id;
    EXPECT_NEAR(stream.prior.covariance(0, 0), 0.25, 1e-12) << fault.id;
    EXPECT_NEAR(stream.prior.covariance(5, 5), std::pow(kRadPerDeg, 2), 1e-12) << fault.id;
    const Pose3& prior = stream.prior.T_map_vehicle;
    const bool is_turned = fault.id == "place-prior-180deg";
    const double distance_m =
        is_turned ? 0.0 : std::stod(fault.id.substr(std::string("place-prior-").size()));
    EXPECT_NEAR(prior.translation_m.norm(), distance_m, 1e-9) << fault.id;
    if (fault.id != "place-prior-20m") {
      EXPECT_NEAR(prior.translation_m.y(), 0.0, 1e-9) << fault.id;
    }
    EXPECT_NEAR(RotationAngle(prior), is_turned ? std::numbers::pi : 0.0, 1e-9) << fault.id;
  }
}

}  // namespace
}  // namespace dcloc::faults
