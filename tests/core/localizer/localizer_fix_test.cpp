#include "core/localizer/localizer.h"
#include "tests/core/localizer/on_a_road.h"

namespace dcloc {
namespace {

// A drive with a fix of a receiver at every fifth scan.
class LocalizerFixTest : public OnARoad {
 protected:
  static PositionFix FixAt(const TrueScan& seen, double ahead_m, double left_m,
                           double sigma_m = 1.5) {
    PositionFix fix{.stamp = seen.scan.stamp, .pose = {}};
    fix.pose.T_map_vehicle = Embed(Pose2{
        .translation_m = (seen.T_map_vehicle * Eigen::Vector3d(ahead_m, left_m, 0.0)).head<2>(),
        .yaw_rad = 0.0});
    Vector6d sigmas;
    sigmas << sigma_m, sigma_m, 2.0, 0.05, 0.05, 1.8;
    fix.pose.covariance = sigmas.cwiseAbs2().asDiagonal();
    return fix;
  }

  // Fixes are off by (ahead, left) from scan `begin` on.
  static std::vector<TrueAnswer> Localize(Localizer localizer, const std::vector<TrueScan>& drive,
                                          double ahead_m, double left_m, std::size_t begin = 0) {
    std::vector<TrueAnswer> answers;
    for (std::size_t i = 0; i < drive.size(); ++i) {
      absl::StatusOr<Localization> answer = localizer.Localize(drive[i].scan);
      EXPECT_TRUE(answer.ok()) << answer.status();
      if (answer.ok()) answers.push_back({*answer, drive[i].T_map_vehicle});
      if (i % 5 != 0) continue;
      const bool is_off = i >= begin;
      last_use_ =
          *localizer.TakeFix(FixAt(drive[i], is_off ? ahead_m : 0.3, is_off ? left_m : 0.2));
    }
    return answers;
  }

  static inline FixUse last_use_ = FixUse::kOutOfTime;
};

TEST_F(LocalizerFixTest, StartsASearch) {
  const Errors errors =
      ErrorsOf(Localize(MakeLocalizer(map_, FrontRadar(), std::nullopt), drive_, 0.5, -0.5));
  EXPECT_GT(errors.tracking_count, static_cast<int>(drive_.size()) / 2);
  EXPECT_LT(errors.max_m, 2.0);
  EXPECT_EQ(last_use_, FixUse::kConsistentNotFused);
}

TEST_F(LocalizerFixTest, ReflectionsForceNoPose) {
  const std::size_t third = drive_.size() / 3;
  const Errors without = ErrorsOf(
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive_));
  for (const double ahead_m : {-30.0, -8.0, 8.0, 30.0}) {
    const Errors errors =
        ErrorsOf(Localize(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive_,
                          ahead_m, 0.25 * ahead_m, third));
    EXPECT_LT(errors.max_m, 1.1 * without.max_m + 0.05) << ahead_m;
    EXPECT_GT(errors.tracking_count, 3 * without.tracking_count / 4) << ahead_m;
    EXPECT_EQ(last_use_, FixUse::kContradicted) << ahead_m;
  }
}

TEST_F(LocalizerFixTest, CorrectAWrongPriorThatLooksRight) {
  const Errors errors = ErrorsOf(Localize(
      MakeLocalizer(map_, FrontRadar(),
                    PriorAt(Start() * Embed(Pose2{.translation_m = {40.0, 0.0}}), 0.5, 0.02)),
      drive_, 0.3, 0.2));
  EXPECT_LT(errors.max_m, 2.0);
  EXPECT_GT(errors.tracking_count, static_cast<int>(drive_.size()) / 3);
}

// However far a fix lies from the pose, it is called fused exactly where the pose has become more
// certain by it.
TEST_F(LocalizerFixTest, OneIsCalledFusedWhereItWas) {
  constexpr std::size_t kScan = 60;
  constexpr double kSigma_m = 0.08;
  const auto last_answer = [&](std::optional<double> left_m, FixUse* use) {
    Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02));
    for (std::size_t i = 0; i < kScan; ++i) EXPECT_TRUE(localizer.Localize(drive_[i].scan).ok());
    if (left_m) *use = *localizer.TakeFix(FixAt(drive_[kScan - 1], 0.0, *left_m, kSigma_m));
    return *localizer.Localize(drive_[kScan].scan);
  };
  const auto variance = [](const Localization& answer) {
    return answer.covariance.topLeftCorner<2, 2>().trace();
  };
  FixUse use{};
  const double without = variance(last_answer(std::nullopt, &use));
  int fused_count = 0;
  int contradicted_count = 0;
  for (double left_m = 0.0; left_m < 1.0; left_m += 0.05) {
    const double with = variance(last_answer(left_m, &use));
    EXPECT_EQ(use == FixUse::kFused, with < 0.98 * without) << left_m;
    (use == FixUse::kFused ? fused_count : contradicted_count)++;
  }
  EXPECT_GT(fused_count, 2);
  EXPECT_GT(contradicted_count, 2);
}

// Of two that are as good, less than a second apart, one moves the pose.
TEST_F(LocalizerFixTest, OneThatAgreesAMomentLaterLeavesThePoseAsItIs) {
  const auto answer_after = [&](int fix_count, FixUse* use) {
    Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02));
    for (std::size_t i = 0; i < 60; ++i) EXPECT_TRUE(localizer.Localize(drive_[i].scan).ok());
    for (int i = 0; i < fix_count; ++i) *use = *localizer.TakeFix(FixAt(drive_[59], 0, 0.05, 0.08));
    return localizer.Localize(drive_[60].scan)->T_map_vehicle;
  };
  FixUse use{};
  const Pose3 without = answer_after(0, &use);
  const Pose3 once = answer_after(1, &use);
  EXPECT_EQ(use, FixUse::kFused);
  const Pose3 twice = answer_after(2, &use);
  EXPECT_EQ(use, FixUse::kConsistentNotFused);
  EXPECT_GT(Log(without.Inverse() * once).norm(), 0.0);
  EXPECT_EQ(Log(once.Inverse() * twice).norm(), 0.0);
}

TEST_F(LocalizerFixTest, OldAndBrokenFixesChangeNothing) {
  Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02));
  for (std::size_t i = 0; i < 40; ++i) ASSERT_TRUE(localizer.Localize(drive_[i].scan).ok());
  EXPECT_EQ(*localizer.TakeFix(FixAt(drive_[10], 0.0, 0.0)), FixUse::kOutOfTime);
  PositionFix ahead = FixAt(drive_[39], 0.0, 0.0);
  ahead.stamp += std::chrono::minutes(10);
  EXPECT_EQ(*localizer.TakeFix(ahead), FixUse::kOutOfTime);
  PositionFix broken = FixAt(drive_[39], 0.0, 0.0);
  broken.pose.covariance(0, 0) = -1.0;
  EXPECT_FALSE(localizer.TakeFix(broken).ok());
  EXPECT_EQ(*localizer.TakeFix(FixAt(drive_[35], 0.0, 0.0)), FixUse::kConsistentNotFused);
  EXPECT_TRUE(localizer.Localize(drive_[40].scan)->state == LocalizationState::kTracking);
}

class MountTest : public OnARoad {};

TEST_F(MountTest, ARadarThatWasKnockedIsFoundOutAndCorrected) {
  Rig real = FrontRadar();
  real.radars[0].T_vehicle_radar.rotation =
      Eigen::AngleAxisd(9.0 * kDegree, Eigen::Vector3d::UnitZ());
  const std::vector<TrueScan> drive = DriveRoad(SyntheticWorld(), real, kLiveSpeed_mps, 2);
  const std::vector<TrueAnswer> answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive);
  const Errors errors = ErrorsOf(answers);
  EXPECT_LT(errors.max_m, 1.0);
  EXPECT_LT(errors.max_rad, 5.0 * kDegree);
  EXPECT_GT(errors.tracking_count, static_cast<int>(drive.size()) / 2);
  EXPECT_EQ(answers.back().localization.health.radars[0].fault, SourceFault::kMount);
  EXPECT_TRUE(answers.back().localization.health.radars[0].is_used);
}

}  // namespace
}  // namespace dcloc
