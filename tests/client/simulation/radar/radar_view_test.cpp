#include "client/simulation/radar/radar_view.h"

#include <gtest/gtest.h>

#include <numbers>

namespace dcloc::simulation {
namespace {

constexpr double kQuarterTurn = 0.5 * std::numbers::pi;

TEST(RadarViewTest, AStandingTargetAheadComesNearer) {
  const MotionState motion{Pose2{{100.0, 0.0}, kQuarterTurn}, 20.0};
  const RadarView view = ViewFrom(motion, Embed(Pose2{{3.0, 0.0}, 0.0}));
  const Observation ahead = view.Observe({100.0, 53.0, 0.0}, Eigen::Vector3d::Zero());
  EXPECT_NEAR(ahead.range_m, 50.0, 1e-9);
  EXPECT_NEAR(ahead.azimuth_rad, 0.0, 1e-9);
  EXPECT_NEAR(ahead.range_rate_mps, -20.0, 1e-9);
  const Observation abeam = view.Observe({90.0, 3.0, 10.0}, Eigen::Vector3d::Zero());
  EXPECT_NEAR(abeam.azimuth_rad, kQuarterTurn, 1e-9);
  EXPECT_NEAR(abeam.elevation_rad, 0.5 * kQuarterTurn, 1e-9);
  EXPECT_NEAR(abeam.range_rate_mps, 0.0, 1e-9);
  const Observation leader = view.Observe({100.0, 53.0, 0.0}, {0.0, 25.0, 0.0});
  EXPECT_NEAR(leader.range_rate_mps, 5.0, 1e-9);  // it drives away
}

TEST(RadarViewTest, InACurveTheMountsLeverMovesTheRadar) {
  const MotionState motion{Pose2{}, 0.0, 0.5};
  const RadarView view = ViewFrom(motion, Embed(Pose2{{4.0, 0.0}, kQuarterTurn}));
  EXPECT_NEAR(view.velocity_mps.y(), 2.0, 1e-12);
  // The radar looks to the left, which is where it goes.
  EXPECT_NEAR(view.Observe({4.0, 10.0, 0.0}, Eigen::Vector3d::Zero()).range_rate_mps, -2.0, 1e-9);
}

}  // namespace
}  // namespace dcloc::simulation
