#include "core/odometry/odometry_error_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/odometry/rig_knowledge.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

// What is wrong with what a vehicle reports, and with where its registrations put it.
struct Faults {
  double scale = 1.0;
  double yaw_rate_bias_radps = 0.0;
  double sideslip_rad = 0.0;
  double time_offset_s = 0.0;
};

// A vehicle that weaves and changes its speed, ten scans a second, registered once a second.
class Drive {
 public:
  // Poses vary by `pose_sigma_m` and say that they vary by 0.03 m.
  explicit Drive(const Faults& faults, double pose_sigma_m = kStatedSigma_m)
      : faults_(faults), pose_sigma_m_(pose_sigma_m) {}

  void Second(OdometryErrorFilter& errors, bool with_pose = true) {
    for (int scan = 0; scan < 10; ++scan, ++scan_) {
      speed_mps_ = 12.0 + 6.0 * std::sin(0.02 * scan_);
      yaw_rate_radps_ = 0.1 * std::sin(0.013 * scan_);
      const Eigen::Vector3d velocity(speed_mps_, 0.0, yaw_rate_radps_);
      T_map_vehicle_ = T_map_vehicle_ * Embed(Exp(Eigen::Vector3d(kScan_s * velocity)));
      const Eigen::Vector3d reported(
          errors.scale() / faults_.scale * speed_mps_, 0.0,
          yaw_rate_radps_ - faults_.yaw_rate_bias_radps + errors.yaw_rate_bias_radps());
      errors.OnMotion(Embed(Exp(Eigen::Vector3d(kScan_s * reported))), milliseconds(100),
                      speed_origin);
    }
    if (with_pose) errors.OnPose(Registered(), Covariance());
  }

  OdometryErrorFilter::SpeedOrigin speed_origin = OdometryErrorFilter::SpeedOrigin::kWheels;

  void Become(const Faults& faults) { faults_ = faults; }
  void JumpInMap() { T_map_vehicle_.translation_m.x() += 500.0; }
  void TurnUnreported(double turn_rad) {
    T_map_vehicle_ = T_map_vehicle_ * Embed(Pose2{.yaw_rad = turn_rad});
  }

 private:
  static constexpr double kScan_s = 0.1;
  static constexpr double kStatedSigma_m = 0.03;
  static constexpr double kPoseSigma_rad = 0.001;

  static Eigen::Matrix3d Covariance() {
    return Eigen::Vector3d(kStatedSigma_m, kStatedSigma_m, kPoseSigma_rad).cwiseAbs2().asDiagonal();
  }

  Pose3 Registered() {
    const Eigen::Vector3d late(faults_.time_offset_s * speed_mps_, 0.0,
                               faults_.time_offset_s * yaw_rate_radps_);
    const double x_m = pose_sigma_m_ * normal_(random_);
    const double y_m = pose_sigma_m_ * normal_(random_);
    const Eigen::Vector3d noise(x_m, y_m, kPoseSigma_rad * normal_(random_));
    return T_map_vehicle_ * Embed(Exp(late)) * Embed(Pose2{.yaw_rad = -faults_.sideslip_rad}) *
           Embed(Exp(noise));
  }

  Faults faults_;
  double pose_sigma_m_;
  Pose3 T_map_vehicle_;
  double speed_mps_ = 0.0;
  double yaw_rate_radps_ = 0.0;
  int scan_ = 0;
  std::mt19937 random_{8};
  std::normal_distribution<double> normal_;
};

OdometryErrorFilter After(int seconds, Drive drive,
                          const OdometryErrorFilterOptions& options = {}) {
  OdometryErrorFilter errors(options);
  for (int second = 0; second < seconds; ++second) drive.Second(errors);
  return errors;
}

TEST(OdometryErrorFilterTest, CorrectsNothingAtFirst) {
  const OdometryErrorFilter errors({.scale_sigma = 0.03});
  EXPECT_EQ(errors.scale(), 1.0);
  EXPECT_EQ(errors.scale_sigma(), 0.03);
  EXPECT_EQ(errors.yaw_rate_bias_radps(), 0.0);
}

TEST(OdometryErrorFilterTest, LearnsScaleAndYawRateBias) {
  const OdometryErrorFilter errors =
      After(60, Drive({.scale = 1.017, .yaw_rate_bias_radps = 0.0012}));
  EXPECT_NEAR(errors.scale(), 1.017, 0.001);
  EXPECT_NEAR(errors.yaw_rate_bias_radps(), 0.0012, 1e-4);
  EXPECT_EQ(errors.scale_sigma(), OdometryErrorFilterOptions().min_scale_sigma);
}

TEST(OdometryErrorFilterTest, AnotherSourceTellsTheScale) {
  OdometryErrorFilter errors({.scale_sigma = 0.01});
  errors.OnScale({.value = 1.02, .variance = 1e-4});
  EXPECT_NEAR(errors.scale(), 1.01, 1e-9) << "as likely as that nothing is wrong";
  EXPECT_NEAR(errors.scale_sigma(), 0.01 / std::sqrt(2.0), 1e-9);
  EXPECT_EQ(errors.yaw_rate_bias_radps(), 0.0);
}

// The pose that the filter keeps was carried on by the old scale.
TEST(OdometryErrorFilterTest, AScaleThatIsToldLateCorrectsThePoseToo) {
  Drive drive({.scale = 1.02});
  OdometryErrorFilter errors({.scale_sigma = 0.01});
  drive.Second(errors);
  for (int second = 0; second < 5; ++second) drive.Second(errors, false);
  errors.OnScale({.value = 1.02, .variance = 1e-6});
  EXPECT_NEAR(errors.scale(), 1.02, 5e-4);
  drive.Second(errors);
  EXPECT_NEAR(errors.scale(), 1.02, 1e-3) << "the pose contradicts nothing";
}

// Between rails, registrations slide along the track with odometry, and then catch up.
TEST(OdometryErrorFilterTest, PosesThatSlideTeachLittleOnceDopplerHasSpoken) {
  OdometryErrorFilter errors({});
  errors.OnScale({.value = 1.003, .variance = 4e-5});
  Pose3 T_map_vehicle;
  const double slide_m[] = {0.0, 0.35, 0.35, 1.0, 1.1, 1.1};
  constexpr double kBlunt_m = 0.7;
  for (const double slid_m : slide_m) {
    Pose3 registered = T_map_vehicle;
    registered.translation_m.x() += slid_m;
    errors.OnPose(registered, Eigen::Vector3d(kBlunt_m, 0.02, 0.001).cwiseAbs2().asDiagonal());
    for (int scan = 0; scan < 10; ++scan) {
      const Pose3 step = Embed(Exp(Eigen::Vector3d(1.25, 0.0, 0.0)));
      T_map_vehicle = T_map_vehicle * step;
      errors.OnMotion(Embed(Exp(Eigen::Vector3d(1.25 * errors.scale(), 0.0, 0.0))),
                      milliseconds(75));
    }
  }
  EXPECT_NEAR(errors.scale(), 1.0, 0.008);
}

TEST(OdometryErrorFilterTest, FindsNothingInOdometryThatIsRight) {
  const OdometryErrorFilter errors = After(60, Drive({}));
  EXPECT_NEAR(errors.scale(), 1.0, 0.001);
  EXPECT_NEAR(errors.yaw_rate_bias_radps(), 0.0, 1e-4);
}

TEST(OdometryErrorFilterTest, TakesTurnedMountsForNeitherScaleNorYawRate) {
  const OdometryErrorFilter errors = After(60, Drive({.sideslip_rad = 0.015}));
  EXPECT_NEAR(errors.scale(), 1.0, 0.001);
  EXPECT_NEAR(errors.yaw_rate_bias_radps(), 0.0, 1.5e-4);
}

TEST(OdometryErrorFilterTest, TakesClocksThatDifferForNoScale) {
  const OdometryErrorFilter errors = After(60, Drive({.time_offset_s = 0.06}));
  EXPECT_NEAR(errors.scale(), 1.0, 0.001);
}

TEST(OdometryErrorFilterTest, LearnsWithinTwelveSeconds) {
  // Of some 140 m, by poses with a deviation of 0.1 m.
  const OdometryErrorFilter errors = After(12, Drive({.scale = 1.012}));
  EXPECT_NEAR(errors.scale(), 1.012, 0.0025);
}

TEST(OdometryErrorFilterTest, LearnsNothingWithoutPoses) {
  OdometryErrorFilter errors({});
  Drive drive({.scale = 1.02});
  for (int second = 0; second < 30; ++second) drive.Second(errors, false);
  EXPECT_EQ(errors.scale(), 1.0);
  EXPECT_EQ(errors.yaw_rate_bias_radps(), 0.0);
}

TEST(OdometryErrorFilterTest, WeighsPosesLessThatExceedTheirCovariance) {
  const OdometryErrorFilterOptions options{.min_scale_sigma = 0.0};
  const OdometryErrorFilter errors = After(40, Drive({}, 1.0), options);
  EXPECT_NEAR(errors.scale(), 1.0, 3.0 * errors.scale_sigma());
  EXPECT_GT(errors.scale_sigma(), 1.2 * After(40, Drive({}), options).scale_sigma());
}

TEST(OdometryErrorFilterTest, OneWrongPoseChangesLittle) {
  OdometryErrorFilter errors({});
  Drive drive({.scale = 1.01});
  for (int second = 0; second < 30; ++second) drive.Second(errors);
  const double before = errors.scale();
  drive.JumpInMap();
  drive.Second(errors);
  EXPECT_NEAR(errors.scale(), before, 0.02);
}

TEST(OdometryErrorFilterTest, LearnsWithinSecondsWhatChangesAtOnce) {
  OdometryErrorFilter errors({});
  Drive drive({});
  for (int second = 0; second < 30; ++second) drive.Second(errors);
  const Faults faults{.yaw_rate_bias_radps = -0.05};
  drive.Become(faults);
  for (int second = 0; second < 10; ++second) drive.Second(errors);
  EXPECT_NEAR(errors.yaw_rate_bias_radps(), -0.05, 0.004);
  drive.Become({});
  for (int second = 0; second < 10; ++second) drive.Second(errors);
  EXPECT_NEAR(errors.yaw_rate_bias_radps(), 0.0, 0.004);
}

TEST(OdometryErrorFilterTest, SlipIsNoScale) {
  OdometryErrorFilter errors({});
  Drive drive({});
  for (int second = 0; second < 30; ++second) drive.Second(errors);
  drive.Become({.scale = 1.6});
  for (int second = 0; second < 3; ++second) drive.Second(errors);
  EXPECT_NEAR(errors.scale(), 1.0, 0.02);
  drive.Become({});
  for (int second = 0; second < 5; ++second) drive.Second(errors);
  EXPECT_NEAR(errors.scale(), 1.0, 0.02);
}

// What `open` takes is what learning begins with, however far from 1.
TEST(OdometryErrorFilterTest, EveryScaleThatMayBeKnownIsTaken) {
  for (const double scale : {kMinKnownScale, 1.0 / 0.7, kMaxKnownScale}) {
    OdometryErrorFilter errors({});
    errors.Restore(ScalarEstimate{scale, 1e-4}, std::nullopt);
    EXPECT_EQ(errors.scale(), scale);
  }
}

TEST(OdometryErrorFilterTest, APriorIsGivenUpWhereTheDriveContradictsIt) {
  OdometryErrorFilter errors({});
  errors.Restore(ScalarEstimate{1.04, 1e-12}, ScalarEstimate{0.1, 1e-12});
  EXPECT_EQ(errors.scale(), 1.04);
  Drive drive({});
  for (int second = 0; second < 60; ++second) drive.Second(errors);
  EXPECT_NEAR(errors.yaw_rate_bias_radps(), 0.0, 0.004);
  EXPECT_NEAR(errors.scale(), 1.0, 0.01);
}

TEST(OdometryErrorFilterTest, ReportsOnlyWhatItHasLearned) {
  const OdometryErrorFilter fresh({});
  EXPECT_FALSE(fresh.LearnedScale());
  EXPECT_FALSE(fresh.LearnedYawRateBias());
  const OdometryErrorFilter errors = After(60, Drive({.scale = 1.017}));
  ASSERT_TRUE(errors.LearnedScale());
  EXPECT_NEAR(errors.LearnedScale()->value, 1.017, 0.001);
}

TEST(OdometryErrorFilterTest, AJumpInTheMapIsNotTheWheels) {
  OdometryErrorFilter errors({});
  Drive drive({.scale = 1.01});
  for (int second = 0; second < 30; ++second) drive.Second(errors);
  const double before = errors.scale();
  drive.JumpInMap();
  errors.OnDiscontinuity();
  drive.Second(errors);
  EXPECT_EQ(errors.scale(), before);
  for (int second = 0; second < 30; ++second) drive.Second(errors);
  EXPECT_NEAR(errors.scale(), 1.01, 0.001);
}

// A bias makes registrations contradict the pose, which is doubted between any two that count.
TEST(OdometryErrorFilterTest, ABiasIsLearnedFromPosesThatAreDoubtedInBetween) {
  const auto bias_after = [](void (OdometryErrorFilter::*between)()) {
    OdometryErrorFilter errors({});
    Drive drive({});
    for (int second = 0; second < 30; ++second) drive.Second(errors);
    drive.Become({.yaw_rate_bias_radps = 0.0175});
    for (int second = 0; second < 10; ++second) {
      drive.Second(errors);
      (errors.*between)();
    }
    return errors.yaw_rate_bias_radps();
  };
  EXPECT_NEAR(bias_after(&OdometryErrorFilter::OnDoubt), 0.0175, 0.002);
  EXPECT_NEAR(bias_after(&OdometryErrorFilter::OnDiscontinuity), 0.0, 0.002) << "at other places";
}

// A gyroscope that was dead in a turn. What came of it is no bias, however long it is compared.
TEST(OdometryErrorFilterTest, ATurnThatWasNotReportedTeachesNoBias) {
  OdometryErrorFilter errors({});
  Drive drive({.yaw_rate_bias_radps = 0.002});
  for (int second = 0; second < 30; ++second) drive.Second(errors);
  for (int second = 0; second < 3; ++second) {
    drive.TurnUnreported(0.5);
    drive.Second(errors);
  }
  for (int second = 0; second < 60; ++second) {
    drive.Second(errors);
    ASSERT_NEAR(errors.yaw_rate_bias_radps(), 0.002, 0.001) << second;
  }
}

// The speed of others stands in for that of wheels that are set aside.
TEST(OdometryErrorFilterTest, ASpeedThatIsNotTheWheelsTeachesNoScale) {
  OdometryErrorFilter errors({});
  Drive drive({.scale = 1.0, .yaw_rate_bias_radps = 0.002});
  drive.speed_origin = OdometryErrorFilter::SpeedOrigin::kOther;
  for (int second = 0; second < 60; ++second) drive.Second(errors);
  EXPECT_NEAR(errors.yaw_rate_bias_radps(), 0.002, 0.0005) << "the gyroscope's bias is learned";
  EXPECT_NEAR(errors.scale(), 1.0, 1e-6);
  EXPECT_GE(errors.scale_sigma(), 0.01);
  drive.speed_origin = OdometryErrorFilter::SpeedOrigin::kWheels;
  drive.Become({.scale = 1.05, .yaw_rate_bias_radps = 0.002});
  for (int second = 0; second < 30; ++second) drive.Second(errors);
  EXPECT_NEAR(errors.scale(), 1.05, 0.01) << "and the scale, once wheels count";
}

}  // namespace
}  // namespace dcloc
