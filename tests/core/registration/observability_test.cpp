#include "core/registration/observability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/registration/point_clouds.h"

namespace dcloc {
namespace {

constexpr double kSigma_m = 0.15;

GaussianPoint<2> PointAt(double x_m, double y_m) {
  return {.mean_m = {x_m, y_m}, .covariance_m2 = kSigma_m * kSigma_m * Eigen::Matrix2d::Identity()};
}

Observability Look(const std::vector<GaussianPoint<2>>& live,
                   const std::vector<GaussianPoint<2>>& landmarks, const Pose2& T_local_vehicle) {
  std::vector<GaussianPoint<2>> chosen;
  MapFit<2> fit;
  return Observe<2>(live, LocalMap<2>({}, landmarks), T_local_vehicle,
                    Eigen::Vector3d(1e-4, 2e-4, 1e-6).asDiagonal(), {}, {}, chosen, fit);
}

// Two walls along the way, `yaw_rad` to the local frame, without persistent places along them.
std::vector<GaussianPoint<2>> Walls(int count, std::mt19937& random) {
  std::uniform_real_distribution<double> along_m(-60.0, 60.0);
  std::vector<GaussianPoint<2>> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    points.push_back(PointAt(along_m(random), i % 2 == 0 ? 4.0 : -4.0));
  return points;
}

TEST(ObservabilityTest, AmongPlacesOfTheirOwnBothAxesAreObserved) {
  std::mt19937 random(1);
  const Pose2 truth{.translation_m = {3.0, -2.0}, .yaw_rad = 0.4};
  const CloudPair<2> pair = ExactPair<2>(truth, 80, 0.1, random);
  const Observability seen = Look(pair.live, pair.landmarks, truth);
  EXPECT_TRUE(seen.Observed(VehicleAxis::kX));
  EXPECT_TRUE(seen.Observed(VehicleAxis::kY));
  EXPECT_EQ(seen.DegeneracyCovariance(10.0), Eigen::Matrix2d::Zero());
  EXPECT_EQ(seen.BluntCovariance(0.7), Eigen::Matrix2d::Zero());
}

// A dense wall with few posts: posts show a shift of a metre, but half a metre is felt little.
TEST(ObservabilityTest, AlongADenseWallWithAFewPostsTheAlongTrackPositionIsBlunt) {
  std::mt19937 random(4);
  std::vector<GaussianPoint<2>> live = Walls(300, random);
  std::vector<GaussianPoint<2>> landmarks = Walls(600, random);
  for (int i = 0; i < 30; ++i) {
    const GaussianPoint<2> post = PointAt(4.0 * i - 60.0, 8.0);
    live.push_back(post);
    landmarks.push_back(post);
  }
  const Observability seen = Look(live, landmarks, {});
  EXPECT_TRUE(seen.Observed(VehicleAxis::kX));
  const Eigen::Matrix2d blunt = seen.BluntCovariance(0.7);
  EXPECT_NEAR(blunt(0, 0), 0.49, 0.05);
  EXPECT_LT(blunt(1, 1), 1e-3);
}

TEST(ObservabilityTest, AlongSmoothWallsOnlyTheAlongTrackPositionIsNotObserved) {
  std::mt19937 random(2);
  const Observability seen = Look(Walls(300, random), Walls(600, random), {});
  EXPECT_FALSE(seen.Observed(VehicleAxis::kX));
  EXPECT_TRUE(seen.Observed(VehicleAxis::kY));
  const Eigen::Matrix2d degeneracy = seen.DegeneracyCovariance(10.0);
  EXPECT_GT(degeneracy(0, 0), 50.0);
  EXPECT_LT(degeneracy(1, 1), 1e-6);
}

TEST(ObservabilityTest, WithoutInliersAllIsCalledObserved) {
  std::mt19937 random(3);
  const Observability seen = Look(Walls(100, random), {PointAt(500.0, 500.0)}, {});
  EXPECT_TRUE(seen.Observed(VehicleAxis::kX));
  EXPECT_TRUE(seen.Observed(VehicleAxis::kY));
}

}  // namespace
}  // namespace dcloc
