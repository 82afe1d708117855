#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/evaluation/baselines/ego_range_rates.h"
#include "client/evaluation/baselines/estimator.h"
#include "client/evaluation/baselines/map_for_method.h"
#include "client/evaluation/baselines/pcl_registration.h"
#include "client/evaluation/baselines/window_graph.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/runner.h"
#include "tests/client/evaluation/simulated_drives.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

class Baselines : public ::testing::TestWithParam<MethodKind> {
 protected:
  static void SetUpTestSuite() {
    SilencePcl();
    drives_ = new SimulatedDrives(SimulateDrives(0.04));
  }
  static void TearDownTestSuite() { delete drives_; }

  static DriveOutcome Run(const EvaluationOptions& options, const Drive& live) {
    const auto map = MapForMethod(options.method, drives_->map_drive, options.localizer).value();
    auto outcome = Evaluate(map, live, options);
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return outcome.ok() ? *std::move(outcome) : DriveOutcome{};
  }

  static SimulatedDrives* drives_;
};

SimulatedDrives* Baselines::drives_ = nullptr;

std::string NameOfTest(const ::testing::TestParamInfo<MethodKind>& info) {
  constexpr const char* kNames[] = {
      "Icp",   "Ndt",      "McRansac",  "DcLoc",    "DcLocPlusPlus",
      "Dcloc", "DclocIcp", "DclocGicp", "DclocNdt", "DclocDescriptor"};
  return kNames[static_cast<std::size_t>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(All, Baselines,
                         ::testing::Values(MethodKind::kIcp, MethodKind::kNdt,
                                           MethodKind::kMcRansac, MethodKind::kDcLoc,
                                           MethodKind::kDcLocPlusPlus, MethodKind::kDcloc,
                                           MethodKind::kDclocIcp, MethodKind::kDclocGicp,
                                           MethodKind::kDclocNdt, MethodKind::kDclocDescriptor),
                         NameOfTest);

TEST_P(Baselines, TracksADriveFromAPerturbedPose) {
  const DriveOutcome outcome = Run({.method = GetParam()}, drives_->live_drive);
  const Metrics metrics = ComputeMetrics({&outcome, 1});
  EXPECT_EQ(metrics.scan_count, drives_->live_drive.scans.size());
  EXPECT_GT(metrics.success_rate_all, 0.85);
  // The prior is 1 m and 2 degrees off.
  EXPECT_LT(metrics.rte_m.median, 0.3);
  EXPECT_LT(metrics.rre_deg.median, 0.6);
  EXPECT_GT(metrics.stage_ms[2].p50, 0.0);
}

TEST_P(Baselines, AnswersSeparateQueries) {
  EvaluationOptions options{.method = GetParam(), .protocol = Protocol::kPairs};
  options.query_interval_s = 2.0;
  const DriveOutcome outcome = Run(options, drives_->live_drive);
  const Metrics metrics = ComputeMetrics({&outcome, 1});
  EXPECT_GT(metrics.scan_count, 4U);
  EXPECT_GT(metrics.success_rate_all, 0.7);
  EXPECT_LT(metrics.rte_m.median, 0.4);
}

TEST_P(Baselines, GivesTheSameAnswersAgain) {
  const EvaluationOptions options{
      .method = GetParam(), .protocol = Protocol::kPairs, .query_interval_s = 4.0};
  const DriveOutcome a = Run(options, drives_->live_drive);
  const DriveOutcome b = Run(options, drives_->live_drive);
  ASSERT_EQ(a.scans.size(), b.scans.size());
  for (std::size_t i = 0; i < a.scans.size(); ++i) {
    EXPECT_EQ(a.scans[i].error.tangent, b.scans[i].error.tangent);
  }
}

TEST_P(Baselines, RefusesWhatTheLocalizerRefuses) {
  Drive drive = drives_->live_drive;
  drive.scans.resize(30);
  drive.scans[5].scan.range_m.front() = -1.0F;
  drive.scans[9].scan.stamp = drive.scans[8].scan.stamp - std::chrono::seconds(1);
  drive.scans[12].scan.radar_id = "nobody";
  const DriveOutcome outcome = Run({.method = GetParam()}, drive);
  EXPECT_EQ(outcome.refused_count, 3U);
  EXPECT_EQ(outcome.scans.size(), 27U);
}

TEST_P(Baselines, SurvivesScansWithoutTargets) {
  Drive drive = drives_->live_drive;
  drive.scans.resize(40);
  for (DriveScan& entry : drive.scans) {
    Scan empty;
    empty.stamp = entry.scan.stamp;
    empty.radar_id = entry.scan.radar_id;
    entry.scan = empty;
  }
  const DriveOutcome outcome = Run({.method = GetParam()}, drive);
  EXPECT_EQ(outcome.scans.size(), 40U);
  for (const ScanOutcome& scan : outcome.scans) EXPECT_FALSE(scan.answered());
}

TEST_P(Baselines, NeedsAnInitialPoseUnlessItRunsInTheLocalizer) {
  EvaluationOptions options{.method = GetParam()};
  options.has_initial_pose = false;
  const auto map = MapForMethod(options.method, drives_->map_drive, options.localizer).value();
  Drive drive = drives_->live_drive;
  drive.scans.resize(1);
  const auto outcome = Evaluate(map, drive, options);
  EXPECT_EQ(outcome.ok(), RunsInLocalizer(GetParam()));
  if (!outcome.ok()) {
    EXPECT_THAT(std::string(outcome.status().message()),
                HasSubstr("method " + MethodName(GetParam()) + " needs an initial pose"));
  }
}

TEST(WithEgoRangeRates, IsWhatStandingTargetsWouldGive) {
  const RadarModel radar{.id = "front"};
  Scan scan;
  scan.radar_id = "front";
  scan.range_m = {10.0F, 10.0F};
  scan.azimuth_rad = {0.0F, 1.5707963F};
  scan.range_rate_mps = {7.0F, 7.0F};
  EgoVelocity velocity;
  velocity.linear_mps.x() = 5.0;
  const Scan result = WithEgoRangeRates(scan, radar, velocity);
  EXPECT_FLOAT_EQ(result.range_rate_mps[0], -5.0F);
  EXPECT_NEAR(result.range_rate_mps[1], 0.0, 1e-5);
  EXPECT_EQ(result.range_m, scan.range_m);
}

PoseEstimate<2> At(double x_m, double variance) {
  return {.pose = {.translation_m = {x_m, 0.0}},
          .covariance = variance * Eigen::Matrix3d::Identity()};
}

TEST(WindowGraph, WeighsEdgesByTheirCovariance) {
  WindowGraph graph(5);
  graph.Reset(At(0.0, 1.0));
  graph.AddState(At(1.0, 1.0));
  graph.AddAbsolutePose(At(2.0, 1.0));
  graph.Solve();
  // The prediction is 1 with variance 2, the loop 2 with variance 1.
  EXPECT_NEAR(graph.Newest().pose.translation_m.x(), 1.0 + 2.0 / 3.0, 1e-6);
  EXPECT_NEAR(graph.Newest().covariance(0, 0), 2.0 / 3.0, 1e-6);
}

TEST(WindowGraph, ForgetsWhatLeavesTheWindow) {
  WindowGraph graph(2);
  graph.Reset(At(0.0, 1e-6));
  for (int i = 0; i < 3; ++i) graph.AddState(At(1.0, 1e-2));
  graph.AddAbsolutePose(At(5.0, 1.0));
  graph.Solve();
  EXPECT_NEAR(graph.Newest().pose.translation_m.x(), 5.0, 1e-6);
}

TEST(WindowGraph, FollowsItsFrame) {
  WindowGraph graph(5);
  graph.Reset(At(3.0, 1.0));
  graph.AddState(At(1.0, 1.0));
  graph.ChangeFrame({.translation_m = {-4.0, 2.0}});
  graph.Solve();
  EXPECT_NEAR(graph.Newest().pose.translation_m.x(), 0.0, 1e-9);
  EXPECT_NEAR(graph.Newest().pose.translation_m.y(), 2.0, 1e-9);
}

PlanarFit MatchAt(double x_m) {
  return {.T_local_vehicle = {.translation_m = {x_m, 0.0}},
          .covariance = 0.01 * Eigen::Matrix3d::Identity()};
}

// As printed, a match is compared with the previous raw match: the first of two wrong ones is cut,
// the second is not.
TEST(GraphEstimator, CutsAJumpButIsFooledByTwo) {
  const auto estimator = MakeGraphEstimator(At(0.0, 1.0), {});
  EXPECT_TRUE(estimator->Correct(MatchAt(0.1), {}).has_value());
  EXPECT_TRUE(estimator->Correct(MatchAt(0.0), {}).has_value());
  EXPECT_FALSE(estimator->Correct(MatchAt(3.0), {}).has_value());
  EXPECT_LT(estimator->Now().T_local_vehicle.translation_m.x(), 0.2);
  EXPECT_TRUE(estimator->Correct(MatchAt(3.0), {}).has_value());
}

TEST(FrameEstimator, TakesTheMatchAndRefusesTheImpossible) {
  const auto estimator = MakeFrameEstimator(At(0.0, 1.0));
  EXPECT_FALSE(estimator->Correct(std::nullopt, {}).has_value());
  EXPECT_FALSE(estimator->Correct(MatchAt(20.0), {}).has_value());
  EXPECT_EQ(estimator->Now().T_local_vehicle.translation_m.x(), 0.0);
  EXPECT_TRUE(estimator->Correct(MatchAt(1.5), {}).has_value());
  EXPECT_EQ(estimator->Now().T_local_vehicle.translation_m.x(), 1.5);
}

}  // namespace
}  // namespace dcloc
