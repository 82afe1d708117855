#include "core/localizer/odometry_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dcloc {
namespace {

// A vehicle whose speed is reported too low by 1.7 %, on a road that bends as `curvature_radpm`
// says; its poses are told with an error.
class Drive {
 public:
  explicit Drive(double curvature_radpm, double pose_sigma_m = 0.1)
      : curvature_radpm_(curvature_radpm), noise_m_(0.0, pose_sigma_m) {}

  void Metre(OdometryScale& scale, bool tell_pose = true) {
    const Pose2 T_now_next = Exp(Eigen::Vector3d(1.0, 0.0, curvature_radpm_));
    T_map_vehicle_ = T_map_vehicle_ * Embed(T_now_next);
    Pose3 by_odometry = Embed(T_now_next);
    by_odometry.translation_m *= scale.factor() / kTruth;
    scale.OnMotion(by_odometry);
    if (!tell_pose) return;
    Pose3 told = T_map_vehicle_;
    for (int i = 0; i < 2; ++i) told.translation_m(i) += noise_m_(random_);
    scale.OnPose(told);
  }

  void JumpInMap() { T_map_vehicle_.translation_m.x() += 500.0; }

  static constexpr double kTruth = 1.017;

 private:
  double curvature_radpm_;
  Pose3 T_map_vehicle_;
  std::mt19937 random_{8};
  std::normal_distribution<double> noise_m_;
};

TEST(OdometryScaleTest, IsOneAndUncertainAtFirst) {
  const OdometryScale scale({.prior_sigma = 0.02});
  EXPECT_EQ(scale.factor(), 1.0);
  EXPECT_EQ(scale.sigma(), 0.02);
}

TEST(OdometryScaleTest, LearnsOnAStraightRoadAndInBends) {
  for (const double curvature_radpm : {0.0, 0.02}) {
    OdometryScale scale({});
    Drive drive(curvature_radpm);
    for (int metre = 0; metre < 600; ++metre) drive.Metre(scale);
    EXPECT_NEAR(scale.factor(), Drive::kTruth, 2.0 * scale.sigma()) << curvature_radpm;
    EXPECT_LT(scale.sigma(), 0.006);
  }
}

TEST(OdometryScaleTest, LearnsNothingWithoutPosesOrWhileItTurnsOnTheSpot) {
  OdometryScale scale({});
  Drive straight(0.0);
  for (int metre = 0; metre < 100; ++metre) straight.Metre(scale, false);
  EXPECT_EQ(scale.factor(), 1.0);
  Drive circle(0.5);  // once round in 12.6 m
  for (int metre = 0; metre < 200; ++metre) circle.Metre(scale);
  EXPECT_EQ(scale.factor(), 1.0);
  EXPECT_EQ(scale.sigma(), OdometryScaleOptions().prior_sigma);
}

TEST(OdometryScaleTest, LearnsSoonerFromBetterPoses) {
  double off_by[2];
  for (const bool is_good : {false, true}) {
    OdometryScale scale({});
    Drive drive(0.0, is_good ? 0.02 : 0.4);
    for (int metre = 0; metre < 250; ++metre) drive.Metre(scale);
    off_by[is_good] = std::abs(scale.factor() - Drive::kTruth);
    EXPECT_LT(off_by[is_good], 3.0 * scale.sigma());
  }
  EXPECT_LT(off_by[true], 0.002);
  EXPECT_LT(off_by[true], off_by[false]);
}

TEST(OdometryScaleTest, AJumpInTheMapIsNotTheWheels) {
  OdometryScale scale({});
  Drive drive(0.0);
  for (int metre = 0; metre < 110; ++metre) drive.Metre(scale);
  const double before = scale.factor();
  drive.JumpInMap();
  scale.OnJump();
  drive.Metre(scale);
  EXPECT_EQ(scale.factor(), before);
  for (int metre = 0; metre < 500; ++metre) drive.Metre(scale);
  EXPECT_NEAR(scale.factor(), Drive::kTruth, 0.012);
}

}  // namespace
}  // namespace dcloc
