#include "client/evaluation/pose_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace dcloc {
namespace {

const std::bitset<6> kPlanar(0b100011);  // x, y, yaw
const std::bitset<6> kSpatial(0b111111);

Pose3 At(double x_m, double y_m, double z_m, double yaw_rad) {
  Pose3 pose = Embed(Pose2{{x_m, y_m}, yaw_rad});
  pose.translation_m.z() = z_m;
  return pose;
}

TEST(ComparePoses, MeasuresTranslationAndRotationInSpace) {
  const PoseError error = ComparePoses(At(10.0, 20.0, 0.0, 1.0), Matrix6d::Identity(), kSpatial,
                                       At(13.0, 24.0, 12.0, 1.0 + std::numbers::pi / 90.0));
  EXPECT_NEAR(error.translation_m, 13.0, 1e-12);
  EXPECT_NEAR(error.rotation_deg, 2.0, 1e-9);
  EXPECT_EQ(error.dof, 6);
}

TEST(ComparePoses, TakesTheErrorInTheEstimatesFrame) {
  // The vehicle looks along y; the truth is 1 m further along y, ahead of it.
  Matrix6d covariance = Matrix6d::Identity();
  covariance(0, 0) = 0.25;  // along the vehicle's x
  const double quarter_rad = std::numbers::pi / 2.0;
  const PoseError error = ComparePoses(At(0.0, 0.0, 0.0, quarter_rad), covariance, kPlanar,
                                       At(0.0, 1.0, 0.0, quarter_rad));
  EXPECT_NEAR(error.tangent[0], 1.0, 1e-12);
  EXPECT_NEAR(error.nees, 4.0, 1e-9);
}

TEST(ComparePoses, CountsObservedDegreesOfFreedomOnly) {
  Matrix6d covariance = 0.01 * Matrix6d::Identity();
  const PoseError planar =
      ComparePoses(At(0.0, 0.0, 0.0, 0.0), covariance, kPlanar, At(0.1, 0.0, 5.0, 0.0));
  EXPECT_EQ(planar.dof, 3);
  EXPECT_NEAR(planar.nees, 1.0, 1e-9);
  EXPECT_GT(planar.translation_m, 5.0);
}

TEST(ComparePoses, UsesTheMarginalOfACorrelatedCovariance) {
  Matrix6d covariance = Matrix6d::Identity();
  covariance(0, 2) = covariance(2, 0) = 0.9;  // x with the unobserved z: the margin of x stays 1
  const PoseError error =
      ComparePoses(At(0.0, 0.0, 0.0, 0.0), covariance, kPlanar, At(2.0, 0.0, 0.0, 0.0));
  EXPECT_NEAR(error.nees, 4.0, 1e-9);
}

TEST(ComparePoses, CallsACertainWrongAnswerInfinitelyWrong) {
  const PoseError error =
      ComparePoses(At(0.0, 0.0, 0.0, 0.0), Matrix6d::Zero(), kPlanar, At(0.1, 0.0, 0.0, 0.0));
  EXPECT_TRUE(std::isinf(error.nees));
}

TEST(ChiSquare, HasTheQuantilesOfTheDistribution) {
  EXPECT_NEAR(ChiSquare95(3), 7.815, 1e-3);
  EXPECT_NEAR(ChiSquare999(3), 16.266, 1e-3);
  EXPECT_NEAR(ChiSquare95(6), 12.592, 1e-3);
  EXPECT_NEAR(ChiSquare999(6), 22.458, 1e-3);
}

}  // namespace
}  // namespace dcloc
