#include "core/geometry/covariance.h"

#include <gtest/gtest.h>

#include <random>

namespace dcloc {
namespace {

Matrix6d RandomCovariance(std::mt19937& random, double sigma) {
  std::normal_distribution<double> normal(0.0, sigma);
  Matrix6d root;
  for (double& value : root.reshaped()) value = normal(random);
  return root * root.transpose();
}

// d f(xi) / d xi at zero by central differences; the independent truth of the Jacobians.
template <typename Function>
Matrix6d NumericJacobian(const Function& function) {
  constexpr double kStep = 1e-6;
  Matrix6d jacobian;
  for (int column = 0; column < 6; ++column) {
    const Vector6d step = kStep * Vector6d::Unit(column);
    jacobian.col(column) = (function(step) - function(Vector6d(-step))) / (2.0 * kStep);
  }
  return jacobian;
}

TEST(CovarianceTest, CompositionMatchesNumericJacobians) {
  std::mt19937 random(3);
  const Pose3 T_a_b = Exp(Vector6d(Vector6d::Constant(0.7)));
  Vector6d xi;
  xi << 4.0, -2.0, 1.0, 0.3, -0.6, 0.9;
  const Pose3 T_b_c = Exp(xi);
  const Matrix6d S_ab = RandomCovariance(random, 0.1);
  const Matrix6d S_bc = RandomCovariance(random, 0.1);
  const Pose3 T_a_c = T_a_b * T_b_c;
  const Matrix6d J = NumericJacobian(
      [&](const Vector6d& step) { return Log(T_a_c.Inverse() * (T_a_b * Exp(step) * T_b_c)); });
  const Matrix6d truth = J * S_ab * J.transpose() + S_bc;
  EXPECT_LT((ComposeCovariance<3>(S_ab, T_b_c, S_bc) - truth).norm(), 1e-6 * truth.norm());
}

TEST(CovarianceTest, InversionMatchesNumericJacobians) {
  std::mt19937 random(4);
  Vector6d xi;
  xi << 4.0, -2.0, 1.0, 0.3, -0.6, 0.9;
  const Pose3 T = Exp(xi);
  const Matrix6d S = RandomCovariance(random, 0.1);
  const Matrix6d J =
      NumericJacobian([&](const Vector6d& step) { return Log(T * (T * Exp(step)).Inverse()); });
  const Matrix6d truth = J * S * J.transpose();
  EXPECT_LT((InvertCovariance<3>(T, S) - truth).norm(), 1e-6 * truth.norm());
}

TEST(CovarianceTest, FixedAxesOfAVehicleHeadingNorth) {
  // Uncertain along its own x axis only; heading along the map's y, that is the map's y.
  const Pose3 T{
      .rotation = Eigen::Quaterniond(Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitZ()))};
  Matrix6d tangent = Matrix6d::Zero();
  tangent(0, 0) = 4.0;
  tangent(3, 3) = 9.0;
  const Matrix6d fixed = FixedAxesFromTangent(T, tangent);
  EXPECT_NEAR(fixed(1, 1), 4.0, 1e-12);
  EXPECT_NEAR(fixed(0, 0), 0.0, 1e-12);
  EXPECT_NEAR(fixed(4, 4), 9.0, 1e-12);
  EXPECT_LT((TangentFromFixedAxes(T, fixed) - tangent).norm(), 1e-12);
}

TEST(CovarianceTest, FlattenInvertsEmbed) {
  Eigen::Matrix3d planar;
  planar << 4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 1.0;
  const Matrix6d embedded = EmbedCovariance(planar, 9.0, 0.25);
  EXPECT_EQ(FlattenCovariance(embedded), planar);
  EXPECT_EQ(embedded(2, 2), 9.0);
  EXPECT_EQ(embedded(4, 4), 0.25);
}

TEST(CovarianceTest, RecognisesWhatIsNone) {
  EXPECT_TRUE(IsCovariance(Matrix6d::Identity()));
  Matrix6d broken = Matrix6d::Identity();
  broken(2, 2) = -1.0;
  EXPECT_FALSE(IsCovariance(broken));
  broken = Matrix6d::Identity();
  broken(0, 1) = 0.5;
  EXPECT_FALSE(IsCovariance(broken));
  broken = Matrix6d::Identity();
  broken(0, 0) = std::nan("");
  EXPECT_FALSE(IsCovariance(broken));
}

}  // namespace
}  // namespace dcloc
