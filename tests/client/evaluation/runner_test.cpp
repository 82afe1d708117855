#include "client/evaluation/runner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/evaluation/metrics.h"
#include "tests/client/evaluation/simulated_drives.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

class Runner : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    drives_ = new SimulatedDrives(SimulateDrives());
    map_ = new std::shared_ptr<const RadarMap>(MapOf(drives_->map_drive));
  }
  static void TearDownTestSuite() {
    delete map_;
    delete drives_;
  }

  static DriveOutcome Run(const Drive& drive, const EvaluationOptions& options) {
    auto outcome = Evaluate(*map_, drive, options);
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return outcome.ok() ? *std::move(outcome) : DriveOutcome{};
  }

  static SimulatedDrives* drives_;
  static std::shared_ptr<const RadarMap>* map_;
};

SimulatedDrives* Runner::drives_ = nullptr;
std::shared_ptr<const RadarMap>* Runner::map_ = nullptr;

TEST_F(Runner, TracksADriveFromAPerturbedPose) {
  const DriveOutcome outcome = Run(drives_->live_drive, {});
  const Metrics metrics = ComputeMetrics({&outcome, 1});
  EXPECT_EQ(outcome.drive, drives_->live_drive.name);
  EXPECT_EQ(metrics.scan_count, drives_->live_drive.scans.size());
  EXPECT_EQ(metrics.refused_count, 0U);
  EXPECT_GT(metrics.answered_count, metrics.scan_count * 9 / 10);
  EXPECT_LT(metrics.rte_m.median, 0.3);
  EXPECT_LT(metrics.rre_deg.median, 1.0);
  EXPECT_EQ(metrics.misleading_count, 0U);
  EXPECT_GT(metrics.total_ms.p50, 0.0);
  EXPECT_GT(metrics.stage_ms[2].p50, 0.0);
}

TEST_F(Runner, JudgesEachAnswerByTheReferenceAtItsStamp) {
  const DriveOutcome outcome = Run(drives_->live_drive, {});
  ASSERT_EQ(outcome.scans.size(), drives_->live_drive.scans.size());
  for (std::size_t i = 0; i < outcome.scans.size(); ++i) {
    const ScanOutcome& scan = outcome.scans[i];
    const DriveScan& entry = drives_->live_drive.scans[i];
    EXPECT_EQ(scan.answer.stamp, entry.scan.stamp);
    EXPECT_EQ(scan.T_map_vehicle_true.translation_m, entry.T_map_vehicle.translation_m);
    EXPECT_NEAR(
        scan.error.translation_m,
        (scan.answer.T_map_vehicle.translation_m - entry.T_map_vehicle.translation_m).norm(), 1e-9);
  }
}

TEST_F(Runner, GivesTheSameAnswersAgain) {
  const DriveOutcome a = Run(drives_->live_drive, {});
  const DriveOutcome b = Run(drives_->live_drive, {});
  ASSERT_EQ(a.scans.size(), b.scans.size());
  for (std::size_t i = 0; i < a.scans.size(); ++i) {
    EXPECT_EQ(a.scans[i].error.translation_m, b.scans[i].error.translation_m);
    EXPECT_EQ(a.scans[i].error.nees, b.scans[i].error.nees);
  }
}

TEST_F(Runner, AsksSeparateQueriesAtIntervals) {
  EvaluationOptions options;
  options.protocol = Protocol::kPairs;
  options.query_interval_s = 1.0;
  options.first_query_s = 2.0;
  const DriveOutcome outcome = Run(drives_->live_drive, options);
  const auto& scans = drives_->live_drive.scans;
  const double duration_s =
      std::chrono::duration<double>(scans.back().scan.stamp - scans.front().scan.stamp).count();
  EXPECT_EQ(outcome.scans.size(), static_cast<std::size_t>(duration_s - 2.0) + 1);
  for (std::size_t i = 0; i < outcome.scans.size(); ++i) {
    const double asked_s = 2.0 + static_cast<double>(i);
    const double answered_s =
        std::chrono::duration<double>(outcome.scans[i].answer.stamp - scans.front().scan.stamp)
            .count();
    EXPECT_LE(answered_s, asked_s + 1e-9);
    EXPECT_GT(answered_s, asked_s - 0.1);
  }
  EXPECT_LT(ComputeMetrics({&outcome, 1}).rte_m.median, 0.5);
}

TEST_F(Runner, TakesTheVehiclesOwnVelocityAwayWhenAsked) {
  EvaluationOptions options;
  options.doppler_ego_velocity = true;
  const DriveOutcome doppler = Run(drives_->live_drive, options);
  Drive without = drives_->live_drive;
  for (DriveScan& entry : without.scans) entry.scan.ego_velocity.reset();
  const DriveOutcome removed = Run(without, {});
  const DriveOutcome sensor = Run(drives_->live_drive, {});
  ASSERT_EQ(doppler.scans.size(), removed.scans.size());
  EXPECT_EQ(doppler.scans.back().error.translation_m, removed.scans.back().error.translation_m);
  EXPECT_NE(doppler.scans.back().error.translation_m, sensor.scans.back().error.translation_m);
}

TEST_F(Runner, CountsRefusedScansAndGoesOn) {
  Drive drive = drives_->live_drive;
  drive.scans[5].scan.range_m.front() = -1.0F;
  drive.scans[9].scan.stamp = drive.scans[8].scan.stamp - std::chrono::seconds(1);
  const DriveOutcome outcome = Run(drive, {});
  EXPECT_EQ(outcome.refused_count, 2U);
  EXPECT_EQ(outcome.scans.size(), drive.scans.size() - 2);
  EXPECT_THAT(outcome.first_refusal, HasSubstr("range_m"));
}

TEST_F(Runner, NamesOptionsThatMakeNoSense) {
  const auto message = [&](const EvaluationOptions& options) {
    return std::string(Evaluate(*map_, drives_->live_drive, options).status().message());
  };
  EvaluationOptions options;
  options.perturbation.translation_m = -1.0;
  EXPECT_THAT(message(options), HasSubstr("perturbation.translation_m is -1"));
  options = {};
  options.query_interval_s = 0.0;
  EXPECT_THAT(message(options), HasSubstr("query_interval_s is 0"));
  options = {};
  options.localizer.scans_per_submap = 0;
  EXPECT_THAT(message(options), HasSubstr("scans_per_submap"));
  Drive empty = drives_->live_drive;
  empty.scans.clear();
  EXPECT_FALSE(Evaluate(*map_, empty, {}).ok());
}

}  // namespace
}  // namespace dcloc
