#include "core/geometry/pose.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <unsupported/Eigen/MatrixFunctions>

namespace dcloc {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The 4 x 4 generator of an SE(3) tangent vector; its matrix exponential is the independent truth.
Matrix4d Hat(const Vector6d& xi) {
  Matrix4d hat = Matrix4d::Zero();
  hat.topLeftCorner<3, 3>() = Skew(xi.tail<3>());
  hat.topRightCorner<3, 1>() = xi.head<3>();
  return hat;
}

Matrix4d Homogeneous(const Pose3& T) {
  Matrix4d matrix = Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = T.Rotation();
  matrix.topRightCorner<3, 1>() = T.translation_m;
  return matrix;
}

class PoseTest : public ::testing::Test {
 protected:
  Vector6d RandomTangent(double scale) {
    std::uniform_real_distribution<double> uniform(-scale, scale);
    Vector6d xi;
    for (double& value : xi) value = uniform(random_);
    return xi;
  }
  std::mt19937 random_{7};
};

TEST_F(PoseTest, ExpIsTheMatrixExponential) {
  for (const double scale : {1e-7, 1e-3, 1.0, 1.7}) {
    const Vector6d xi = RandomTangent(scale);
    const Matrix4d truth = Hat(xi).exp();
    EXPECT_LT((Homogeneous(Exp(xi)) - truth).norm(), 1e-12) << "scale " << scale;
  }
}

TEST_F(PoseTest, PlanarExpIsTheEmbeddedOne) {
  for (const double scale : {1e-7, 1e-3, 1.0, 3.0}) {
    const Vector6d xi = RandomTangent(scale);
    const Vector3d planar(xi(0), xi(1), xi(5));
    Vector6d embedded = Vector6d::Zero();
    embedded << xi(0), xi(1), 0.0, 0.0, 0.0, xi(5);
    EXPECT_LT((Homogeneous(Embed(Exp(planar))) - Homogeneous(Exp(embedded))).norm(), 1e-12);
  }
}

TEST_F(PoseTest, LogInvertsExp) {
  for (const double scale : {1e-9, 1e-4, 0.1, 1.7}) {
    const Vector6d xi = RandomTangent(scale);
    EXPECT_LT((Log(Exp(xi)) - xi).norm(), 1e-11);
    const Vector3d planar(xi(0), xi(1), xi(5));
    EXPECT_LT((Log(Exp(planar)) - planar).norm(), 1e-11);
  }
}

TEST_F(PoseTest, AdjointMovesThePerturbationToTheLeft) {
  const Pose3 T = Exp(RandomTangent(1.5));
  const Vector6d xi = RandomTangent(0.4);
  EXPECT_LT((Homogeneous(T * Exp(xi)) - Homogeneous(Exp(Vector6d(Adjoint(T) * xi)) * T)).norm(),
            1e-12);
  const Pose2 flat = Exp(Vector3d(3.0, -2.0, 1.0));
  const Vector3d planar(0.3, 0.2, -0.5);
  const Pose2 right = flat * Exp(planar);
  const Pose2 left = Exp(Vector3d(Adjoint(flat) * planar)) * flat;
  EXPECT_LT((right.translation_m - left.translation_m).norm(), 1e-12);
  EXPECT_NEAR(right.yaw_rad, left.yaw_rad, 1e-12);
}

TEST_F(PoseTest, InverseUndoes) {
  const Pose3 T = Exp(RandomTangent(2.0));
  EXPECT_LT(Log(T * T.Inverse()).norm(), 1e-12);
  const Pose2 flat{.translation_m = Vector2d(4.0, -1.0), .yaw_rad = 2.5};
  EXPECT_LT(Log(flat.Inverse() * flat).norm(), 1e-12);
}

TEST(WrapAngleTest, LiesInTheHalfOpenInterval) {
  constexpr double kPi = std::numbers::pi;
  EXPECT_DOUBLE_EQ(WrapAngle(-kPi), kPi);
  EXPECT_DOUBLE_EQ(WrapAngle(kPi), kPi);
  EXPECT_NEAR(WrapAngle(5.0 * kPi + 0.25), -kPi + 0.25, 1e-12);
}

TEST(FlattenTest, InvertsEmbedAndIgnoresTilt) {
  const Pose2 flat{.translation_m = Vector2d(4.0, -1.0), .yaw_rad = 2.5};
  EXPECT_LT(Log(flat.Inverse() * Flatten(Embed(flat))).norm(), 1e-12);
  const Pose3 pitched{.translation_m = Vector3d(1.0, 2.0, 3.0),
                      .rotation = Eigen::AngleAxisd(0.7, Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(0.2, Vector3d::UnitY())};
  EXPECT_NEAR(Flatten(pitched).yaw_rad, 0.7, 1e-12);
}

}  // namespace
}  // namespace dcloc
