#include "core/posegraph/edge_residual.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>
#include <type_traits>

#include "tests/core/posegraph/chain.h"

namespace dcloc {
namespace {

template <typename Dimension>
class EdgeResidualTest : public ::testing::Test {};

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(EdgeResidualTest, Dimensions);

template <int Dim>
Pose<Dim> RandomPose(std::mt19937& random, double scale) {
  return Exp(DrawTangent<Dim>(Diagonal<Dim>(10.0 * scale, scale), random));
}

template <int Dim>
TangentMatrix<Dim> FullCovariance(std::mt19937& random) {
  TangentMatrix<Dim> root;
  for (int i = 0; i < Pose<Dim>::kDof; ++i) {
    root.col(i) = DrawTangent<Dim>(Diagonal<Dim>(0.3, 0.1), random);
  }
  return root * root.transpose() + Diagonal<Dim>(0.05, 0.02);
}

template <int Dim>
Tangent<Dim> Residual(const Pose<Dim>& measured, const TangentMatrix<Dim>& covariance,
                      const Pose<Dim>& from, const Pose<Dim>& to) {
  const EdgeResidual<Dim> edge(measured, covariance);
  Tangent<Dim> residual;
  EXPECT_TRUE(edge(ToParameters(from).data(), ToParameters(to).data(), residual.data()));
  return residual;
}

TYPED_TEST(EdgeResidualTest, IsZeroWhereTheStatesAreAsMeasured) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose<kDim> from = RandomPose<kDim>(random, 2.0);
    const Pose<kDim> measured = RandomPose<kDim>(random, 2.0);
    const Tangent<kDim> residual =
        Residual<kDim>(measured, FullCovariance<kDim>(random), from, from * measured);
    EXPECT_LT(residual.norm(), 1e-11);
  }
}

TYPED_TEST(EdgeResidualTest, SquaredIsTheMahalanobisDistanceOfSmallDifferences) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose<kDim> from = RandomPose<kDim>(random, 1.0);
    const Pose<kDim> measured = RandomPose<kDim>(random, 1.0);
    const TangentMatrix<kDim> covariance = FullCovariance<kDim>(random);
    const Tangent<kDim> xi = DrawTangent<kDim>(Diagonal<kDim>(1e-5, 1e-5), random);
    const double squared =
        Residual<kDim>(measured, covariance, from, from * measured * Exp(xi)).squaredNorm();
    const double truth = xi.dot(covariance.inverse() * xi);
    EXPECT_NEAR(squared, truth, 1e-3 * truth);
  }
}

TYPED_TEST(EdgeResidualTest, NoiseOfItsCovarianceGivesUnitVariances) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(3);
  const Pose<kDim> measured = RandomPose<kDim>(random, 0.5);
  const TangentMatrix<kDim> covariance = 1e-6 * FullCovariance<kDim>(random);
  TangentMatrix<kDim> second_moment = TangentMatrix<kDim>::Zero();
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Pose<kDim> to = measured * Exp(DrawTangent<kDim>(covariance, random));
    const Tangent<kDim> r = Residual<kDim>(measured, covariance, Pose<kDim>{}, to);
    second_moment += r * r.transpose() / kTrials;
  }
  // Deviation of a mean of squares: sqrt(2 / 4000) = 0.022; five times that.
  EXPECT_LT((second_moment - TangentMatrix<kDim>::Identity()).cwiseAbs().maxCoeff(), 0.11);
}

TEST(EdgeResidualPlanarTest, WholeTurnsDoNotCount) {
  const Pose2 from{.yaw_rad = 3.1};
  const Pose2 to{.yaw_rad = -3.1};
  const Pose2 measured{.yaw_rad = 2.0 * std::numbers::pi - 6.2};
  const Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  EXPECT_LT(Residual<2>(measured, covariance, from, to).norm(), 1e-12);
  EXPECT_NEAR(Residual<2>({}, covariance, from, to)(2), 2.0 * std::numbers::pi - 6.2, 1e-12);
}

TEST(EdgeResidualSpatialTest, BothQuaternionsOfARotationAreTheSame) {
  std::mt19937 random(4);
  const Pose3 from = RandomPose<3>(random, 1.0);
  const Pose3 measured = RandomPose<3>(random, 1.0);
  Pose3 to = from * measured * Exp(Vector6d(Vector6d::Constant(0.05)));
  const Vector6d residual = Residual<3>(measured, Matrix6d::Identity(), from, to);
  to.rotation.coeffs() *= -1.0;
  EXPECT_LT((Residual<3>(measured, Matrix6d::Identity(), from, to) - residual).norm(), 1e-12);
  EXPECT_LT(residual.tail<3>().norm(), 0.1);
}

}  // namespace
}  // namespace dcloc
