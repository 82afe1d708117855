#include "client/datasets/finish_drive.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

/// A way of 0.5 m a scan along x, by a vehicle whose frame is pitched on it, nose up.
Drive Straight(int scan_count, double pitch_rad, double step_m = 0.5) {
  Drive drive;
  for (int i = 0; i < scan_count; ++i) {
    DriveScan& entry = drive.scans.emplace_back();
    entry.T_map_vehicle.translation_m.x() = step_m * i;
    entry.T_map_vehicle.rotation = Eigen::AngleAxisd(-pitch_rad, Eigen::Vector3d::UnitY());
  }
  return drive;
}

TEST(TiltOfWayTest, ALevelFrameMovesInItsOwnPlane) {
  EXPECT_NEAR(TiltOfWay(Straight(100, 0.0)).value(), 0.0, 1e-12);
}

TEST(TiltOfWayTest, OfAFrameThatLooksUpTheWayLeadsDown) {
  EXPECT_NEAR(TiltOfWay(Straight(100, 0.04)).value(), -0.04, 1e-9);
  EXPECT_NEAR(TiltOfWay(Straight(100, 0.04, -0.5)).value(), -0.04, 1e-9) << "backwards";
}

TEST(TiltOfWayTest, AShortWayTellsNothing) {
  EXPECT_FALSE(TiltOfWay(Straight(30, 0.04)).has_value());
  EXPECT_FALSE(TiltOfWay(Drive()).has_value());
}

}  // namespace
}  // namespace dcloc
