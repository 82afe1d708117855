#include "client/evaluation/outcome_trajectory.h"

#include <gtest/gtest.h>

#include <chrono>

namespace dcloc {
namespace {

TEST(OutcomeTrajectoryTest, OnlyAnswersThatArePosesAreInIt) {
  DriveOutcome outcome{.drive = "live"};
  for (int i = 0; i < 3; ++i) {
    ScanOutcome scan;
    scan.answer.stamp = Stamp(std::chrono::seconds(i));
    scan.answer.state =
        i == 0 ? LocalizationState::kInitializing : LocalizationState::kDeadReckoning;
    scan.answer.T_map_vehicle.translation_m.x() = i;
    outcome.scans.push_back(scan);
  }
  outcome.scans.push_back(outcome.scans.back());  // another radar's, of the same stamp
  const GeodeticAnchor anchor{.origin = {.latitude_deg = 48.0}};
  const Trajectory trajectory = TrajectoryOf(outcome, anchor);
  EXPECT_EQ(trajectory.name, "live");
  EXPECT_EQ(trajectory.anchor->origin.latitude_deg, 48.0);
  ASSERT_EQ(trajectory.poses.size(), 2U);
  EXPECT_EQ(trajectory.poses[0].T_map_vehicle.translation_m.x(), 1.0);
}

}  // namespace
}  // namespace dcloc
