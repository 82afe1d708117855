#include "core/registration/gicp.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <random>
#include <type_traits>

#include "tests/core/registration/point_clouds.h"

namespace dcloc {
namespace {

template <typename Dimension>
class GicpTest : public ::testing::Test {};

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(GicpTest, Dimensions);

template <int Dim>
Tangent<Dim> ErrorOf(const Pose<Dim>& estimate, const Pose<Dim>& truth) {
  return Log(truth.Inverse() * estimate);
}

template <int Dim>
Registration<Dim> Register(const CloudPair<Dim>& pair, const Pose<Dim>& start,
                           const GicpOptions& options = {}) {
  return RegisterGicp<Dim>(pair.live, LocalMap<Dim>({}, pair.landmarks), start, options);
}

TYPED_TEST(GicpTest, ExactPointsGiveTheExactPose) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(1);
  const Pose<kDim> truth = SmallMotion<kDim>(5.0, 0.3);
  const CloudPair<kDim> pair = ExactPair<kDim>(truth, 80, 0.1, random);
  const auto result = Register<kDim>(pair, truth * SmallMotion<kDim>(0.08, 0.003));
  EXPECT_TRUE(result.converged);
  EXPECT_LT((ErrorOf<kDim>(result.T_local_vehicle, truth).norm()), 1e-6);
  EXPECT_EQ(result.inlier_count, 80);
  EXPECT_DOUBLE_EQ(result.overlap, 1.0);
  EXPECT_GT(result.score, 0.999);
  EXPECT_LT(result.residual_scale, 1e-4);
}

TYPED_TEST(GicpTest, NoisyPointsGiveThePoseWithinItsCovariance) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(2);
  const Pose<kDim> truth = SmallMotion<kDim>(-3.0, 2.5);
  const CloudPair<kDim> pair = Noisy<kDim>(ExactPair<kDim>(truth, 120, 0.2, random), random);
  const auto result = Register<kDim>(pair, truth * SmallMotion<kDim>(0.2, 0.005));
  EXPECT_TRUE(result.converged);
  const Tangent<kDim> error = ErrorOf<kDim>(result.T_local_vehicle, truth);
  EXPECT_LT(error.template head<kDim>().norm(), 0.08);
  EXPECT_LT(error.template tail<Pose<kDim>::kDof - kDim>().norm(), 0.005);
  // 99.99 % of chi-square with 6 degrees of freedom.
  EXPECT_LT(error.dot(result.covariance.inverse() * error), 27.9);
  EXPECT_NEAR(result.residual_scale, 1.0, 0.15);
  EXPECT_GT(result.overlap, 0.95);
}

TYPED_TEST(GicpTest, StartsFromFurtherAwayWithBlur) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(3);
  const Pose<kDim> truth = SmallMotion<kDim>(2.0, 0.4);
  const CloudPair<kDim> pair = Noisy<kDim>(ExactPair<kDim>(truth, 100, 0.1, random), random);
  const GicpOptions blurred{.initial_blur_m = 1.0};
  const auto result = Register<kDim>(pair, truth * SmallMotion<kDim>(0.9, 0.01), blurred);
  EXPECT_TRUE(result.converged);
  EXPECT_LT((ErrorOf<kDim>(result.T_local_vehicle, truth).norm()), 0.06);
}

struct Spread {
  double ratio;  ///< of the mean squared error to what the covariance says, mean over directions
  double nees;   ///< normalized estimation error squared per degree of freedom
};

template <int Dim>
Spread MonteCarlo(int trials, const GicpOptions& options) {
  std::mt19937 random(4);
  const Pose<Dim> truth = SmallMotion<Dim>(1.5, -0.8);
  // Points 4 m apart with deviations of 0.1 m: which landmark is whose is never in degeneracy.
  const CloudPair<Dim> exact = ExactPair<Dim>(truth, 40, 0.1, random);
  TangentMatrix<Dim> errors = TangentMatrix<Dim>::Zero();
  TangentMatrix<Dim> claimed = TangentMatrix<Dim>::Zero();
  double nees = 0.0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto result = Register<Dim>(Noisy<Dim>(exact, random), truth, options);
    const Tangent<Dim> error = ErrorOf<Dim>(result.T_local_vehicle, truth);
    errors += error * error.transpose() / trials;
    claimed += result.covariance / trials;
    nees += error.dot(result.covariance.inverse() * error) / trials / Pose<Dim>::kDof;
  }
  return {.ratio = (claimed.inverse() * errors).trace() / Pose<Dim>::kDof, .nees = nees};
}

TYPED_TEST(GicpTest, CovarianceIsTheSpreadOfTheEstimates) {
  constexpr int kDim = TypeParam::value;
  // Over 600 trials the sum of 3 or 6 squared errors is known to 3.3 or 2.4 %; four times that.
  // Gates and Huber far out: the textbook's linear estimate.
  const Spread spread = MonteCarlo<kDim>(600, {.gate_sigmas = 100.0, .huber_sigmas = 100.0});
  EXPECT_NEAR(spread.ratio, 1.0, 0.13);
  EXPECT_NEAR(spread.nees, 1.0, 0.13);
}

TYPED_TEST(GicpTest, CovarianceIsNearTheSpreadWithTheDefaults) {
  constexpr int kDim = TypeParam::value;
  // Huber's weights and the gate belong to each sample: the sandwich is an approximation then.
  const Spread spread = MonteCarlo<kDim>(600, {});
  EXPECT_GT(spread.ratio, 0.7);
  EXPECT_LT(spread.ratio, 1.4);
}

TYPED_TEST(GicpTest, OutliersMoveItLittle) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(5);
  const Pose<kDim> truth = SmallMotion<kDim>(1.0, 0.2);
  CloudPair<kDim> pair = ExactPair<kDim>(truth, 100, 0.2, random);
  // Every fifth live point lies about three deviations off, all to the same side.
  for (std::size_t i = 0; i < pair.live.size(); i += 5) {
    const PointMatrix<kDim> R = truth.Rotation();
    const PointMatrix<kDim> joint =
        R.transpose() * pair.landmarks[i].covariance_m2 * R + pair.live[i].covariance_m2;
    const double sigma_m = 1.0 / std::sqrt(PointMatrix<kDim>(joint.inverse())(0, 0));
    pair.live[i].mean_m.x() += 3.0 * sigma_m;
  }
  const GicpOptions square{.huber_sigmas = 1e3};
  const auto robust = Register<kDim>(pair, truth);
  const auto plain = Register<kDim>(pair, truth, square);
  const double robust_m = ErrorOf<kDim>(robust.T_local_vehicle, truth).norm();
  const double plain_m = ErrorOf<kDim>(plain.T_local_vehicle, truth).norm();
  EXPECT_LT(robust_m, 0.7 * plain_m);
  EXPECT_LT(robust_m, 0.12);
  EXPECT_EQ(robust.inlier_count, 100);
}

TYPED_TEST(GicpTest, WhatLiesBeyondTheGatesIsNoMatch) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(6);
  CloudPair<kDim> pair = ExactPair<kDim>({}, 60, 0.05, random);
  for (std::size_t i = 0; i < 20; ++i) pair.live[i].mean_m.y() += 2.0;
  const auto result = Register<kDim>(pair, Pose<kDim>{});
  EXPECT_EQ(result.inlier_count, 40);
  EXPECT_NEAR(result.overlap, 40.0 / 60.0, 1e-12);
  EXPECT_NEAR(result.score, 40.0 / 60.0, 1e-3);
  EXPECT_LT(Log(result.T_local_vehicle).norm(), 1e-6);
}

TEST(GicpWallTest, ASmoothWallHoldsAcrossItselfOnly) {
  // A wall along a line 30 degrees off the x axis: landmarks that are long and thin.
  const Eigen::Rotation2Dd R_local_wall(M_PI / 6.0);
  const Eigen::Matrix2d R = R_local_wall.toRotationMatrix();
  const Eigen::Matrix2d shape = R * Eigen::Vector2d(1.0, 0.0025).asDiagonal() * R.transpose();
  std::vector<GaussianPoint<2>> wall;
  for (int i = -20; i <= 20; ++i) wall.push_back({R * Eigen::Vector2d(i, 5.0), shape});
  const std::vector<GaussianPoint<2>>& live = wall;  // seen from the local frame's own origin
  const auto result = RegisterGicp<2>(live, LocalMap<2>({}, wall), Pose2{});
  ASSERT_EQ(result.inlier_count, 41);
  const Eigen::Matrix2d in_wall = R.transpose() * result.covariance.topLeftCorner<2, 2>() * R;
  EXPECT_GT(in_wall(0, 0), 100.0 * in_wall(1, 1));
  // Closed form: 41 points with twice the shape's variance each; along, the lever arm 5 m of the
  // heading's own variance comes on top.
  const double heading = 2.0 * 0.0025 / (2.0 * 20.0 * 21.0 * 41.0 / 6.0);
  EXPECT_NEAR(in_wall(1, 1), 2.0 * 0.0025 / 41.0, 1e-5);
  EXPECT_NEAR(in_wall(0, 0), 2.0 / 41.0 + 25.0 * heading, 1e-3);
}

TEST(GicpWallTest, WhatNoMatchDeterminesSaysSo) {
  // One landmark and three live points on it: it holds the position, not the heading about it.
  const GaussianPoint<2> landmark{{10.0, 0.0}, 0.01 * Eigen::Matrix2d::Identity()};
  const std::vector<GaussianPoint<2>> live(3, landmark);
  const auto result = RegisterGicp<2>(live, LocalMap<2>({}, {landmark}), Pose2{});
  EXPECT_EQ(result.inlier_count, 3);
  EXPECT_TRUE(result.covariance.allFinite());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(result.covariance);
  EXPECT_GT(solver.eigenvalues()(2), 0.1 * kUnobserved);
  EXPECT_LT(solver.eigenvalues()(1), 1.0);
  EXPECT_GE(solver.eigenvalues()(0), 0.0);
}

template <int Dim>
void ExpectNothing(const Registration<Dim>& result, const Pose<Dim>& start) {
  EXPECT_EQ(result.inlier_count, 0);
  EXPECT_EQ(result.overlap, 0.0);
  EXPECT_EQ(result.score, 0.0);
  EXPECT_FALSE(result.converged);
  EXPECT_LT((ErrorOf<Dim>(result.T_local_vehicle, start).norm()), 1e-12);
  EXPECT_TRUE(result.covariance.allFinite());
  EXPECT_GE(result.covariance.diagonal().minCoeff(), 0.99 * kUnobserved);
}

TYPED_TEST(GicpTest, NothingToMatchIsNoInlierAndNoCrash) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(7);
  const CloudPair<kDim> pair = ExactPair<kDim>({}, 30, 0.1, random);
  const Pose<kDim> start = SmallMotion<kDim>(0.3, 0.1);
  const LocalMap<kDim> map({}, pair.landmarks);
  ExpectNothing<kDim>(RegisterGicp<kDim>({}, map, start), start);
  ExpectNothing<kDim>(RegisterGicp<kDim>(pair.live, LocalMap<kDim>(), start), start);
  ExpectNothing<kDim>(RegisterGicp<kDim>({}, LocalMap<kDim>(), start), start);
  const Pose<kDim> far = SmallMotion<kDim>(1e4, 0.0);
  ExpectNothing<kDim>(RegisterGicp<kDim>(pair.live, map, far), far);
}

TYPED_TEST(GicpTest, OneIterationAtMostWhenAskedSo) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(8);
  const CloudPair<kDim> pair = Noisy<kDim>(ExactPair<kDim>({}, 60, 0.2, random), random);
  const auto result = Register<kDim>(pair, SmallMotion<kDim>(0.3, 0.01), {.max_iterations = 1});
  EXPECT_EQ(result.iterations, 1);
  EXPECT_FALSE(result.converged);
}

}  // namespace
}  // namespace dcloc
