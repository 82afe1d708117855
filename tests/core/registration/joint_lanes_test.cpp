#include "core/registration/joint_lanes.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <random>

#include "tests/core/registration/point_clouds.h"

namespace dcloc {
namespace {

template <typename T>
class JointLanesTest : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(JointLanesTest, Dimensions);

TYPED_TEST(JointLanesTest, AreTheJointCovariancesOfEachLandmark) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    const PointMatrix<kDim> own = RandomCovariance<kDim>(0.4, random);
    std::array<PackedPoint<kDim>, kLaneCount> points;
    for (PackedPoint<kDim>& point : points) {
      point = PackedPoint<kDim>({.mean_m = StandardNormal<kDim>(random),
                                 .covariance_m2 = RandomCovariance<kDim>(0.3, random)});
    }
    const PackedLanes<kDim> landmarks(points.data());
    const JointLanes<kDim> joint(landmarks, own.template cast<float>());
    const std::array<Lanes, kDim> e_m = landmarks.SeenFrom(Eigen::Matrix<float, kDim, 1>::Zero(),
                                                           Eigen::Matrix<float, kDim, 1>::Zero());
    const Lanes squares = joint.ScaledSquare(e_m) / joint.Determinant();
    const Lanes traces = joint.ScaledInverseTrace() / joint.Determinant();
    for (std::size_t lane = 0; lane < kLaneCount; ++lane) {
      const PointMatrix<kDim> expected = points.at(lane).Covariance_m2() + own;
      const PointVector<kDim> mean_m = points.at(lane).mean_m.template cast<double>();
      const double determinant = expected.determinant();
      EXPECT_NEAR(joint.Determinant()[lane], determinant, 1e-4 * determinant);
      const double square = mean_m.dot(expected.inverse() * mean_m);
      EXPECT_NEAR(squares[lane], square, 1e-3 * (1.0 + square));
      const double trace = expected.inverse().trace();
      EXPECT_NEAR(traces[lane], trace, 1e-3 * trace);
      double sum = 0.0;
      for (const Lanes& component : e_m) {
        sum += static_cast<double>(component[lane]) * static_cast<double>(component[lane]);
      }
      EXPECT_NEAR(SquaredNorm(e_m)[lane], sum, 1e-4 * (1.0 + sum));
    }
  }
}

}  // namespace
}  // namespace dcloc
