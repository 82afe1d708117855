#include "core/localizer/current_pose.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

Motion Ahead(double way_m, double sigma_m) {
  Matrix6d covariance = 1e-8 * Matrix6d::Identity();
  covariance(0, 0) = sigma_m * sigma_m;
  return {.T_from_to = Embed(Pose2{{way_m, 0.0}, 0.0}), .covariance = covariance};
}

PoseEstimate<2> At(double x_m) {
  return {.pose = {{x_m, 0.0}, 0.0}, .covariance = 1e-4 * Eigen::Matrix3d::Identity()};
}

TEST(CurrentPoseTest, IsCarriedFromTheNewestStateToTheNewestScan) {
  CurrentPose<2> pose({}, {});
  pose.Reset(At(5.0));
  pose.OnMotion(Ahead(1.0, 0.1));
  pose.OnMotion(Ahead(1.0, 0.1));
  EXPECT_NEAR(pose.Newest().pose.translation_m.x(), 5.0, 1e-12);
  EXPECT_NEAR(pose.Now().pose.translation_m.x(), 7.0, 1e-12);
  EXPECT_NEAR(pose.Now().covariance(0, 0), 1e-4 + 0.02, 1e-6);
  pose.AddState();
  EXPECT_NEAR(pose.Newest().pose.translation_m.x(), 7.0, 1e-12);
  EXPECT_NEAR(pose.Now().pose.translation_m.x(), 7.0, 1e-12);
}

TEST(CurrentPoseTest, AResetIsAtTheNewestScan) {
  CurrentPose<2> pose({}, {});
  pose.Reset(At(5.0));
  pose.OnMotion(Ahead(1.0, 0.1));
  pose.Reset(At(20.0));
  EXPECT_NEAR(pose.Now().pose.translation_m.x(), 20.0, 1e-12);
}

// Odometry that has always been right to the millimetre weighs by that, but not over a gap.
TEST(CurrentPoseTest, WhatIsLearnedOfTheNoiseIsNotUsedOverAGap) {
  const auto sigma_after = [](bool gap) {
    CurrentPose<2> pose({}, {});
    pose.Reset(At(0.0));
    for (int i = 1; i <= 100; ++i) {
      pose.OnMotion(Ahead(1.0, 0.1));
      pose.AddState();
      const PoseEstimate<2> registered = At(i);
      pose.AddAbsolutePose({.pose = registered.pose,
                            .covariance = registered.covariance,
                            .weight_covariance = registered.covariance});
      pose.noise_scales().OnRegistration(registered);
    }
    pose.OnMotion(Ahead(1.0, 0.1));
    if (gap) pose.OnGap();
    return pose.NoiseCovarianceNow()(0, 0);
  };
  EXPECT_GT(sigma_after(true), 2.0 * sigma_after(false));
}

TEST(CurrentPoseTest, NoiseThatIsResetIsThatOfTheModel) {
  CurrentPose<2> pose({}, {});
  pose.noise_scales().OnMotion(ToEstimate<2>(Ahead(1.0, 0.1)));
  const Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d fresh = NoiseScaleEstimator<2>().OdometryCovariance(covariance);
  pose.ResetNoise();
  EXPECT_EQ(pose.noise_scales().OdometryCovariance(covariance), fresh);
}

}  // namespace
}  // namespace dcloc
