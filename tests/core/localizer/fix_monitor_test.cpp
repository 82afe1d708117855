#include "core/localizer/fix_monitor.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

PoseEstimate<3> Estimate(double x_m, double y_m, double yaw_rad, double sigma_m, double sigma_rad) {
  Vector6d sigmas;
  sigmas << sigma_m, sigma_m, 1.0, 0.05, 0.05, sigma_rad;
  return {.pose = Embed(Pose2{.translation_m = {x_m, y_m}, .yaw_rad = yaw_rad}),
          .covariance = sigmas.cwiseAbs2().asDiagonal()};
}

class FixMonitorTest : public ::testing::Test {
 protected:
  FixVerdict Classify(const PoseEstimate<3>& fix) {
    stamp_ += std::chrono::milliseconds(500);
    return monitor_.Classify(stamp_, fix, pose_);
  }

  FixMonitor monitor_{{}};
  PoseEstimate<3> pose_ = Estimate(100.0, 50.0, 1.0, 0.05, 0.002);
  Stamp stamp_{std::chrono::seconds(1)};
};

TEST_F(FixMonitorTest, AFixNearByAgreesAndAddsNothing) {
  EXPECT_EQ(Classify(Estimate(102.0, 49.0, 1.0, 1.5, 0.1)), FixVerdict::kAgrees);
}

TEST_F(FixMonitorTest, AFixInformsAPoseThatIsLessCertainOnceASecond) {
  pose_ = Estimate(100.0, 50.0, 1.0, 3.0, 0.05);
  EXPECT_EQ(Classify(Estimate(102.0, 49.0, 1.0, 1.5, 0.1)), FixVerdict::kFusable);
  EXPECT_EQ(Classify(Estimate(102.0, 49.0, 1.0, 1.5, 0.1)), FixVerdict::kFusable)
      << "not fused yet";
  monitor_.OnFused();
  EXPECT_EQ(Classify(Estimate(102.0, 49.0, 1.0, 1.5, 0.1)), FixVerdict::kAgrees);
  EXPECT_EQ(Classify(Estimate(102.0, 49.0, 1.0, 1.5, 0.1)), FixVerdict::kFusable);
}

TEST_F(FixMonitorTest, OneReflectionContradictsThreeDoSoPersistently) {
  const PoseEstimate<3> far = Estimate(130.0, 50.0, 1.0, 1.5, 0.1);
  EXPECT_EQ(Classify(far), FixVerdict::kContradicts);
  EXPECT_EQ(Classify(far), FixVerdict::kContradicts);
  EXPECT_EQ(Classify(far), FixVerdict::kContradictsPersistently);
}

TEST_F(FixMonitorTest, AgreementBetweenThemEndsIt) {
  const PoseEstimate<3> far = Estimate(130.0, 50.0, 1.0, 1.5, 0.1);
  Classify(far);
  Classify(far);
  Classify(Estimate(100.0, 50.0, 1.0, 1.5, 0.1));
  EXPECT_EQ(Classify(far), FixVerdict::kContradicts);
}

TEST_F(FixMonitorTest, WhatTheRadarsHaveRefutedIsIgnoredForAWhile) {
  const PoseEstimate<3> far = Estimate(130.0, 50.0, 1.0, 1.5, 0.1);
  for (int i = 0; i < 3; ++i) Classify(far);
  monitor_.OnRefuted();
  for (int i = 0; i < 50; ++i) EXPECT_EQ(Classify(far), FixVerdict::kContradicts) << i;
  for (int i = 0; i < 20; ++i) Classify(far);
  EXPECT_EQ(Classify(far), FixVerdict::kContradictsPersistently);
}

TEST_F(FixMonitorTest, AWrongHeadingContradicts) {
  EXPECT_EQ(Classify(Estimate(100.0, 50.0, 2.0, 1.5, 0.1)), FixVerdict::kContradicts);
}

TEST_F(FixMonitorTest, AnUnknownHeadingIsThatOfThePose) {
  PoseEstimate<3> fix = Estimate(100.0, 50.0, 0.0, 1.0, 1.8);
  fix.covariance(0, 0) = 9.0;  // along the map's x axis
  const PoseEstimate<3> with = WithHeadingOf(pose_, fix, {});
  EXPECT_NEAR(Flatten(with.pose).yaw_rad, 1.0, 1e-9);
  EXPECT_EQ(with.covariance(5, 5), pose_.covariance(5, 5));
  const Eigen::Matrix3d R = with.pose.Rotation();
  EXPECT_TRUE((R * with.covariance.topLeftCorner<3, 3>() * R.transpose())
                  .isApprox(fix.covariance.topLeftCorner<3, 3>(), 1e-9));
}

}  // namespace
}  // namespace dcloc
