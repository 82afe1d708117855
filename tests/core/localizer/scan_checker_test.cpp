#include "core/localizer/scan_checker.h"

#include "core/radar/static_points.h"
#include "core/registration/gicp_registration.h"
#include "tests/core/localizer/on_a_road.h"

namespace dcloc {
namespace {

class ScanCheckerTest : public OnARoad {
 protected:
  ScanCheckerTest() : matcher_(map_, std::make_shared<GicpRegistration<2>>(GicpOptions()), {}) {}

  // The fit of a scan of the drive, judged as if it were taken `off` from where it was.
  ScanFit Test(std::size_t i, const Pose2& off) {
    const TrueScan& seen = drive_[i];
    matcher_.MoveTo(seen.T_map_vehicle.translation_m, workspace_.registration);
    const Pose2 T_local_vehicle =
        Flatten(matcher_.T_map_local().Inverse() * seen.T_map_vehicle) * off;
    std::vector<RadarPoint> points;
    StaticPoints(seen.scan, rig_.radars[0],
                 WithCovariance(*seen.scan.ego_velocity, 0.01, MotionOptions()), {}, points);
    return checker_.Test(
        seen.scan.stamp, 0, points,
        {.pose = T_local_vehicle, .covariance = 1e-3 * Eigen::Matrix3d::Identity()}, matcher_,
        workspace_);
  }

  void LearnUntil(std::size_t end) {
    for (std::size_t i = 0; i < end; ++i) {
      Test(i, {});
      checker_.Learn();
    }
  }

  Rig rig_ = FrontRadar();
  MapMatcher<2> matcher_;
  ScanChecker<2> checker_{1, {}};
  Workspace<2> workspace_;
};

TEST_F(ScanCheckerTest, AScanFitsWhereItWasTakenAndNowhereElse) {
  LearnUntil(60);
  for (std::size_t i = 60; i < 100; ++i) {
    EXPECT_EQ(Test(i, {}), ScanFit::kAgrees) << i;
    EXPECT_EQ(Test(i, {{9.0, 0.0}, 0.0}), ScanFit::kContradicts) << i;
    EXPECT_EQ(Test(i, {{0.0, 0.0}, 0.35}), ScanFit::kContradicts) << i;
  }
}

TEST_F(ScanCheckerTest, ScansFromBeforeADoubtDoNotJudgeIt) {
  LearnUntil(60);
  const Stamp then = drive_[60].scan.stamp;
  const auto span = std::chrono::milliseconds(700);
  EXPECT_FALSE(checker_.IsTooSoonToJudge(then, span));
  ASSERT_EQ(Test(60, {{9.0, 0.0}, 0.0}), ScanFit::kContradicts);
  EXPECT_TRUE(checker_.IsTooSoonToJudge(then + std::chrono::milliseconds(699), span));
  EXPECT_FALSE(checker_.IsTooSoonToJudge(then + std::chrono::milliseconds(700), span));
  checker_.OnConfirmed();
  EXPECT_FALSE(checker_.IsTooSoonToJudge(then, span));
}

// What was in the way for a moment must have left the sub-map, too.
TEST_F(ScanCheckerTest, ScansFromBeforeTheyFittedAgainDoNotJudgeADoubt) {
  LearnUntil(60);
  const auto span = std::chrono::milliseconds(700);
  for (std::size_t i = 60; i < 70; ++i) {
    Test(i, {{9.0, 0.0}, 0.0});
    EXPECT_FALSE(checker_.agrees_again());
  }
  EXPECT_FALSE(checker_.IsTooSoonToJudge(drive_[69].scan.stamp + span, span));
  int again = 0;
  for (std::size_t i = 70; i < 75; ++i) {
    Test(i, {});
    if (checker_.agrees_again()) ++again;
  }
  EXPECT_EQ(again, 1);
  EXPECT_TRUE(checker_.IsTooSoonToJudge(drive_[74].scan.stamp, span));
  EXPECT_FALSE(checker_.IsTooSoonToJudge(drive_[74].scan.stamp + span, span));
}

TEST_F(ScanCheckerTest, AfterAResetItExpectsNothing) {
  LearnUntil(60);
  checker_.Reset();
  EXPECT_EQ(Test(60, {{9.0, 0.0}, 0.0}), ScanFit::kUnknown);
}

}  // namespace
}  // namespace dcloc
