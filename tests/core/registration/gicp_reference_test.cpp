#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <type_traits>
#include <vector>

#include "core/registration/gicp.h"
#include "tests/core/registration/point_clouds.h"

// The same cost, minimised by Ceres over its own parameters with derivatives by its own means.

namespace dcloc {
namespace {

constexpr double kHuber_sigmas = 1.0;

template <int Dim>
struct WhitenedDifference {
  PointVector<Dim> q;
  PointVector<Dim> p;
  PointMatrix<Dim> root;  // root^T root is the information

  // (x, y, yaw) or (x, y, z, angle-axis).
  template <typename T>
  bool operator()(const T* parameters, T* residual) const {
    Eigen::Matrix<T, Dim, 1> moved;
    if constexpr (Dim == 2) {
      const T c = ceres::cos(parameters[2]);
      const T s = ceres::sin(parameters[2]);
      moved << c * p.x() - s * p.y(), s * p.x() + c * p.y();
    } else {
      const std::array<T, 3> point = {T(p.x()), T(p.y()), T(p.z())};
      ceres::AngleAxisRotatePoint(parameters + 3, point.data(), moved.data());
    }
    for (int i = 0; i < Dim; ++i) moved(i) += parameters[i];
    Eigen::Map<Eigen::Matrix<T, Dim, 1>> r(residual);
    r = root.template cast<T>() * (q.template cast<T>() - moved);
    return true;
  }
};

template <int Dim>
using Parameters = Eigen::Matrix<double, Pose<Dim>::kDof, 1>;

template <int Dim>
Pose<Dim> ToPose(const Parameters<Dim>& parameters) {
  if constexpr (Dim == 2) {
    return {.translation_m = parameters.template head<2>(), .yaw_rad = parameters(2)};
  } else {
    Eigen::Matrix3d R;
    ceres::AngleAxisToRotationMatrix(parameters.data() + 3, R.data());
    return {.translation_m = parameters.template head<3>(), .rotation = Eigen::Quaterniond(R)};
  }
}

// Minimum for the information matrices frozen at `rotation`.
template <int Dim>
Parameters<Dim> Minimise(const CloudPair<Dim>& pair, const PointMatrix<Dim>& rotation,
                         Parameters<Dim> parameters) {
  ceres::Problem problem;
  for (std::size_t i = 0; i < pair.live.size(); ++i) {
    const PointMatrix<Dim> joint = pair.landmarks[i].covariance_m2 +
                                   rotation * pair.live[i].covariance_m2 * rotation.transpose();
    const PointMatrix<Dim> root = PointMatrix<Dim>(joint.inverse()).llt().matrixU();
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<WhitenedDifference<Dim>, Dim, Pose<Dim>::kDof>(
            new WhitenedDifference<Dim>{pair.landmarks[i].mean_m, pair.live[i].mean_m, root}),
        new ceres::HuberLoss(kHuber_sigmas), parameters.data());
  }
  ceres::Solver::Options options;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.max_num_iterations = 200;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  EXPECT_TRUE(summary.IsSolutionUsable()) << summary.BriefReport();
  return parameters;
}

template <typename Dimension>
class GicpReferenceTest : public ::testing::Test {};

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(GicpReferenceTest, Dimensions);

TYPED_TEST(GicpReferenceTest, FindsTheMinimumThatCeresFinds) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(11);
  for (int trial = 0; trial < 5; ++trial) {
    const Pose<kDim> truth = SmallMotion<kDim>(1.0 + trial, 0.2 * trial);
    const CloudPair<kDim> pair = Noisy<kDim>(ExactPair<kDim>(truth, 50, 0.25, random), random);
    // Gates far out, so that the matches are the true ones; blur to find them.
    const GicpOptions options{.max_iterations = 200,
                              .gate_sigmas = 100.0,
                              .huber_sigmas = kHuber_sigmas,
                              .translation_tolerance_m = 1e-9,
                              .rotation_tolerance_rad = 1e-10};
    const auto result = RegisterGicp<kDim>(pair.live, LocalMap<kDim>({}, pair.landmarks),
                                           truth * SmallMotion<kDim>(0.1, 0.002), options);
    ASSERT_TRUE(result.converged);
    ASSERT_EQ(result.inlier_count, 50);

    Parameters<kDim> parameters = Parameters<kDim>::Zero();
    Pose<kDim> reference = truth;
    for (int freeze = 0; freeze < 6; ++freeze) {
      parameters = Minimise<kDim>(pair, reference.Rotation(), parameters);
      reference = ToPose<kDim>(parameters);
    }
    // Weights are those of a pose up to a milliradian away (CorrespondenceFinder).
    EXPECT_LT(Log(reference.Inverse() * result.T_local_vehicle).norm(), 1e-4);
    EXPECT_GT(Log(truth.Inverse() * result.T_local_vehicle).norm(), 1e-3)
        << "the truth is not the minimum: agreement says something";
  }
}

}  // namespace
}  // namespace dcloc
