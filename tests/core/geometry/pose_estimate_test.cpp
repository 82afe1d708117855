#include "core/geometry/pose_estimate.h"

#include <gtest/gtest.h>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

PoseEstimate<2> Planar() {
  Eigen::Matrix3d covariance;
  covariance << 4.0, 0.5, 0.01, 0.5, 9.0, 0.02, 0.01, 0.02, 0.25;
  return {.pose = {.translation_m = {3.0, -2.0}, .yaw_rad = 0.7}, .covariance = covariance};
}

TEST(PoseEstimateTest, APlanarOneComesBackFromSpace) {
  const PoseEstimate<3> in_space = ToSpace<2>(Planar(), {});
  const PoseEstimate<2> back = FromSpace<2>(in_space.pose, in_space.covariance);
  EXPECT_EQ(back.pose.translation_m, Planar().pose.translation_m);
  EXPECT_NEAR(back.pose.yaw_rad, Planar().pose.yaw_rad, 1e-12);
  EXPECT_LT((back.covariance - Planar().covariance).norm(), 1e-12);
}

TEST(PoseEstimateTest, WhatIsNotObservedGetsItsDeviations) {
  const Matrix6d covariance = ToSpace<2>(Planar(), {.z_m = 0.5, .tilt_rad = 0.03}).covariance;
  EXPECT_NEAR(covariance(2, 2), 0.25, 1e-15);
  EXPECT_NEAR(covariance(3, 3), 9e-4, 1e-15);
  EXPECT_NEAR(covariance(4, 4), 9e-4, 1e-15);
  EXPECT_NEAR(covariance(5, 5), 0.25, 1e-12);
}

TEST(PoseEstimateTest, OneInSpaceStaysAsItIs) {
  const Pose3 pose = Embed(Planar().pose);
  const PoseEstimate<3> same = ToSpace<3>(FromSpace<3>(pose, 2.0 * Matrix6d::Identity()), {});
  EXPECT_EQ(same.pose.translation_m, pose.translation_m);
  EXPECT_EQ(same.covariance, 2.0 * Matrix6d::Identity());
}

TEST(UnobservedSigmasTest, EachFieldIsBounded) { ExpectEachFieldIsBounded<UnobservedSigmas>(); }

}  // namespace
}  // namespace dcloc
