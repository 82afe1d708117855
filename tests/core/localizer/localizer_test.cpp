#include "core/localizer/localizer.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <optional>

#include "tests/core/localizer/on_a_road.h"
#include "tests/core/localizer/synthetic_world.h"

namespace dcloc {
namespace {

class LocalizerTest : public OnARoad {};

TEST_F(LocalizerTest, TracksToAFewCentimetres) {
  const auto answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01)), drive_);
  const Errors errors = ErrorsOf(answers);
  EXPECT_LT(errors.mean_m, 0.08);
  EXPECT_LT(errors.max_m, 0.3);
  EXPECT_LT(errors.max_rad, 1.0 * kDegree);
  EXPECT_LT(errors.first_tracking, 25);
  EXPECT_EQ(errors.tracking_count, static_cast<int>(answers.size()) - errors.first_tracking)
      << "once tracking, always tracking";
  RecordProperty("mean_m", std::to_string(errors.mean_m));
}

TEST_F(LocalizerTest, ItsCovarianceHoldsTheTruth) {
  const auto answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01)), drive_);
  int inside = 0;
  int count = 0;
  for (const TrueAnswer& answer : answers) {
    if (!answer.tracking()) continue;
    const Pose3& estimate = answer.localization.T_map_vehicle;
    const Vector6d error = Log(estimate.Inverse() * answer.T_map_vehicle);
    const Eigen::Vector3d planar(error(0), error(1), error(5));
    const Eigen::Matrix3d covariance = FlattenCovariance(answer.localization.covariance);
    // 99.9 % of chi-square with 3 degrees of freedom.
    inside += planar.dot(covariance.inverse() * planar) < 16.27;
    ++count;
    EXPECT_TRUE(IsCovariance(answer.localization.covariance));
  }
  ASSERT_GT(count, 50);
  EXPECT_GE(inside, 0.97 * count);
}

TEST_F(LocalizerTest, APlanarRigObservesThreeDegreesOfFreedom) {
  const auto answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01)), drive_);
  const TrueAnswer& last = answers.back();
  EXPECT_EQ(last.localization.observed, std::bitset<6>(0b100011)) << "x, y and yaw";
  const Matrix6d& covariance = last.localization.covariance;
  EXPECT_LT(covariance(0, 0), 0.5 * covariance(2, 2));
  EXPECT_LT(covariance(5, 5), 0.5 * covariance(3, 3));
  // What it does not observe comes from the map.
  EXPECT_NEAR(last.localization.T_map_vehicle.translation_m.z(), 0.0, 1e-6);
}

TEST_F(LocalizerTest, TheSameScansGiveTheSameBits) {
  const InitialPose prior = PriorAt(Start(), 1.0, 0.05);
  const auto first = LocalizeDrive(MakeLocalizer(map_, FrontRadar(), prior), drive_);
  const auto second = LocalizeDrive(MakeLocalizer(map_, FrontRadar(), prior), drive_);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    ExpectSame(first[i].localization, second[i].localization);
  }
}

TEST_F(LocalizerTest, WithoutTargetsItDeadReckonsAndIsThenLost) {
  Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01));
  constexpr std::size_t kSeeing = 60;
  for (std::size_t i = 0; i < kSeeing; ++i) ASSERT_TRUE(localizer.Localize(drive_[i].scan).ok());
  bool reckoned = false;
  bool lost = false;
  int quiet_ms = 0;  // since the last registration that was accepted
  double sigma_m = 0.0;
  for (std::size_t i = 0; i < 100; ++i) {
    const double along_m = 0.077 * kLiveSpeed_mps * static_cast<double>(kSeeing + i);
    const Scan empty{.stamp = drive_[0].scan.stamp + std::chrono::milliseconds(77 * (kSeeing + i)),
                     .radar_id = "front",
                     .ego_velocity = SyntheticWorld::VelocityAt(kLiveSpeed_mps)};
    const auto answer = localizer.Localize(empty);
    ASSERT_TRUE(answer.ok()) << answer.status();
    const double now_m = std::sqrt(answer->covariance.topLeftCorner<2, 2>().trace());
    // While older scans are still in the sub-map it may register.
    if (i > 30) {
      EXPECT_GT(now_m, sigma_m);
      EXPECT_NE(answer->state, LocalizationState::kTracking);
      EXPECT_FALSE(answer->quality.is_accepted);
      EXPECT_EQ(answer->quality.inlier_count, 0);
    }
    quiet_ms = answer->quality.is_accepted ? 0 : quiet_ms + 77;
    sigma_m = now_m;
    reckoned = reckoned || answer->state == LocalizationState::kDeadReckoning;
    lost = answer->state == LocalizationState::kLost;
    EXPECT_TRUE(lost || quiet_ms <= 1000) << "a second without the map is enough";
    // The wheels are exact here, so that what is left is the last registration's error.
    const Eigen::Vector3d truth_m = SyntheticWorld::OnRoad(along_m).translation_m;
    if (i < 60) {
      EXPECT_LT((answer->T_map_vehicle.translation_m - truth_m).head<2>().norm(), 0.6);
    }
  }
  EXPECT_TRUE(reckoned);
  EXPECT_TRUE(lost);
}

TEST_F(LocalizerTest, SightAfterAShortBlindnessIsTrackingAgain) {
  Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01));
  std::vector<TrueScan> drive = drive_;
  for (std::size_t i = 50; i < 80; ++i) {
    drive[i].scan = Scan{.stamp = drive[i].scan.stamp,
                         .radar_id = "front",
                         .ego_velocity = drive[i].scan.ego_velocity};
  }
  const auto answers = LocalizeDrive(std::move(localizer), drive);
  EXPECT_EQ(answers[79].localization.state, LocalizationState::kLost);
  EXPECT_TRUE(answers[105].tracking());
  EXPECT_LT(answers[105].position_error_m(), 0.25);
}

TEST_F(LocalizerTest, ASilenceIsSurvivedAndNeverSoldAsTracking) {
  // Two seconds without data: what the vehicle did in them nobody knows.
  std::vector<TrueScan> drive(drive_.begin(), drive_.begin() + 50);
  drive.insert(drive.end(), drive_.begin() + 76, drive_.end());
  const auto answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01)), drive);
  EXPECT_TRUE(answers[49].tracking());
  EXPECT_FALSE(answers[50].tracking());
  EXPECT_GT(std::sqrt(answers[50].localization.covariance(0, 0)), 0.5);
  EXPECT_TRUE(answers[66].tracking());
  EXPECT_LT(answers[66].position_error_m(), 0.25);
}

TEST_F(LocalizerTest, WithoutWheelsDopplerIsEnough) {
  std::vector<TrueScan> drive = drive_;
  for (TrueScan& seen : drive) seen.scan.ego_velocity.reset();
  const auto answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01)), drive);
  const Errors errors = ErrorsOf(answers);
  EXPECT_GT(errors.tracking_count, 80);
  EXPECT_LT(errors.mean_m, 0.12);
}

struct StageRecorder : StageListener {
  std::vector<Stage> stages;
  void OnStageBegin(Stage stage) override { stages.push_back(stage); }
};

TEST_F(LocalizerTest, StagesAreAnnouncedInOrder) {
  Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01));
  std::size_t most = 0;
  for (std::size_t i = 0; i < 40; ++i) {
    StageRecorder recorder;
    ASSERT_TRUE(localizer.Localize(drive_[i].scan, &recorder).ok());
    ASSERT_GE(recorder.stages.size(), 2U);
    EXPECT_TRUE(std::is_sorted(recorder.stages.begin(), recorder.stages.end()));
    EXPECT_EQ(recorder.stages.front(), Stage::kCompensation);
    most = std::max(most, recorder.stages.size());
  }
  EXPECT_EQ(most, 4U);
}

TEST_F(LocalizerTest, WhoTracksRegistersNoSoonerThanItNeedsTo) {
  const LocalizerOptions options;
  Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01));
  std::optional<std::size_t> last;
  LocalizationState state = LocalizationState::kInitializing;
  int eager_count = 0;
  int tracking_count = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    StageRecorder recorder;
    const auto answer = localizer.Localize(drive_[i].scan, &recorder);
    ASSERT_TRUE(answer.ok());
    if (std::ranges::find(recorder.stages, Stage::kRegistration) != recorder.stages.end()) {
      const bool is_tracking = state == LocalizationState::kTracking;
      if (last) {
        EXPECT_EQ(i - *last, is_tracking ? 2U : 1U) << "scan " << i;
        eager_count += is_tracking ? 0 : 1;
      }
      tracking_count += is_tracking ? 1 : 0;
      last = i;
    }
    state = answer->state;
    // Of the newest registration, whether this scan's or not.
    EXPECT_EQ(answer->quality.inlier_count > 0, last.has_value()) << "scan " << i;
  }
  EXPECT_GE(eager_count, options.tracking.min_accepted_registrations - 1);
  EXPECT_GE(tracking_count, 20);
}

// Range-Doppler coupling shifts targets ahead by beta times the closing speed: maps and scans that
// are not compensated disagree by what the two speeds differ.
TEST(LocalizerCouplingTest, WithoutCompensationDifferentSpeedsDisagree) {
  const double beta_s = 0.04;
  const Rig rig = FrontRadar(beta_s);
  const SyntheticWorld world;
  const auto mapping = DriveRoad(world, rig, kMapSpeed_mps, 11);
  const auto drive = DriveRoad(world, rig, kLiveSpeed_mps, 12);
  const InitialPose prior = PriorAt(drive.front().T_map_vehicle, 0.2, 0.01);

  const auto on =
      ErrorsOf(LocalizeDrive(MakeLocalizer(MapOfDrive(mapping, rig), rig, prior), drive));
  const auto raw_map = MapOfDrive(mapping, rig, {.compensate = false});
  const auto off = ErrorsOf(
      LocalizeDrive(MakeLocalizer(raw_map, rig, prior, {.doppler_compensation = false}), drive));
  EXPECT_LT(on.mean_m, 0.08);
  // 0.04 s x 6 m/s = 0.24 m straight ahead, a little less aside.
  EXPECT_GT(off.mean_m, 2.0 * on.mean_m);
  EXPECT_GT(off.mean_m, 0.12);
  EXPECT_LT(off.mean_m, 0.35);
}

TEST(LocalizerInSpaceTest, RigsThatMeasureElevationObserveAllSix) {
  const Rig rig = FrontRadar(0.0, true);
  const SyntheticWorld world(6.0);
  const auto map = MapOfDrive(DriveRoad(world, rig, kMapSpeed_mps, 21), rig);
  ASSERT_TRUE(map->info().has_elevation);
  const auto drive = DriveRoad(world, rig, kLiveSpeed_mps, 22);
  const Pose3 start = drive.front().T_map_vehicle;
  Vector6d off;
  off << 0.3, -0.2, 0.3, 0.01, -0.01, 0.01;
  const auto answers =
      LocalizeDrive(MakeLocalizer(map, rig, PriorAt(start * Exp(off), 0.4, 0.02)), drive);
  const Errors errors = ErrorsOf(answers);
  EXPECT_GT(errors.tracking_count, 80);
  EXPECT_LT(errors.mean_m, 0.1);
  const TrueAnswer& last = answers.back();
  EXPECT_TRUE(last.localization.observed.all());
  const Vector6d error = Log(last.T_map_vehicle.Inverse() * last.localization.T_map_vehicle);
  EXPECT_LT(std::abs(error(2)), 0.15);
  EXPECT_LT(error.tail<3>().norm(), 1.0 * kDegree);
  EXPECT_LT(std::sqrt(last.localization.covariance(2, 2)), 0.3);

  // A planar rig in the same map observes the plane only.
  const Rig planar = FrontRadar();
  const auto flat = DriveRoad(SyntheticWorld(), planar, kLiveSpeed_mps, 23);
  Localizer localizer = MakeLocalizer(map, planar, PriorAt(start, 0.2, 0.01));
  const auto answer = localizer.Localize(flat[0].scan);
  ASSERT_TRUE(answer.ok());
  EXPECT_FALSE(answer->observed[2]);
}

TEST(LocalizerRigTest, SeveralRadarsShareTheWork) {
  Rig rig = FrontRadar();
  RadarModel rear = rig.radars[0];
  rear.id = "rear";
  rear.T_vehicle_radar = Embed(Pose2{.translation_m = {-1.0, 0.0}, .yaw_rad = std::numbers::pi});
  rig.radars.push_back(rear);
  const SyntheticWorld world;
  const auto map = MapOfDrive(DriveRoad(world, rig, kMapSpeed_mps, 31), rig);
  // Both radars' scans carry one stamp.
  const auto drive = DriveRoad(world, rig, kLiveSpeed_mps, 32);
  const auto answers = LocalizeDrive(
      MakeLocalizer(map, rig, PriorAt(drive.front().T_map_vehicle, 0.3, 0.02)), drive);
  const Errors errors = ErrorsOf(answers);
  EXPECT_GT(errors.tracking_count, 160);
  EXPECT_LT(errors.mean_m, 0.08);
  EXPECT_LT(errors.max_m, 0.3);
}

}  // namespace
}  // namespace dcloc
