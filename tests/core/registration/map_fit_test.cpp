#include "core/registration/map_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/registration/correspondences.h"
#include "tests/core/registration/point_clouds.h"

namespace dcloc {
namespace {

template <typename T>
class MapFitTest : public ::testing::Test {
 protected:
  static constexpr int kDim = T::value;

  static std::vector<GaussianPoint<kDim>> RandomPoints(int count, double half_m,
                                                       std::mt19937& random) {
    std::vector<GaussianPoint<kDim>> points;
    for (const PointVector<kDim>& mean_m : SeparatedPoints<kDim>(count, half_m, 0.3, random)) {
      points.push_back({.mean_m = mean_m, .covariance_m2 = RandomCovariance<kDim>(0.3, random)});
      points.back().slant_per_m = 0.01 * StandardNormal<kDim>(random);
      points.back().height_square_m2 = 2.0;
    }
    return points;
  }

  // What an exhaustive search for correspondences makes of it.
  double FitByCorrespondences(const Pose<kDim>& T_local_vehicle, double sigma_m) const {
    CorrespondenceFinder<kDim> finder;
    finder.Begin(live_, map_, gates_);
    double sum = 0.0;
    for (const Correspondence<kDim>& one : finder.Find(T_local_vehicle, sigma_m)) {
      const PointVector<kDim> apart = one.q - T_local_vehicle * one.p;
      sum += std::exp(-0.5 * apart.dot(one.information * apart));
    }
    return sum / static_cast<double>(live_.size());
  }

  std::mt19937 random_{5};
  CorrespondenceGates gates_;
  std::vector<GaussianPoint<kDim>> live_ = RandomPoints(60, 10.0, random_);
  LocalMap<kDim> map_{Pose3(), RandomPoints(400, 12.0, random_)};
  MapFit<kDim> fit_;
};

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(MapFitTest, Dimensions);

// The finder compares logarithms of determinants exactly; where two landmarks are nearly as likely,
// the two may take another one.
TYPED_TEST(MapFitTest, IsThatOfTheCorrespondences) {
  constexpr int kSize = TypeParam::value;
  Pose<kSize> T_local_vehicle;
  T_local_vehicle = T_local_vehicle * Exp(Tangent<kSize>::Constant(0.3).eval());
  for (const double sigma_m : {0.1, 0.3, 0.7}) {
    this->fit_.Begin(this->live_, this->map_, this->gates_, T_local_vehicle, sigma_m);
    for (const double ahead_m : {0.0, 1.0, -4.0}) {
      Pose<kSize> moved = T_local_vehicle;
      moved.translation_m.x() += ahead_m;
      const double fit = this->fit_.At(moved.translation_m);
      EXPECT_NEAR(fit, this->FitByCorrespondences(moved, sigma_m), 0.01);
      EXPECT_GT(fit, 0.05);
    }
  }
}

TYPED_TEST(MapFitTest, IsAtMostWhatItIs) {
  constexpr int kSize = TypeParam::value;
  const Pose<kSize> T_local_vehicle;
  this->fit_.Begin(this->live_, this->map_, this->gates_, T_local_vehicle, 0.3);
  const double fit = this->fit_.At(T_local_vehicle.translation_m);
  for (const double above : {-0.5, -0.1, -1e-6, 1e-6, 0.1, 0.5}) {
    EXPECT_EQ(this->fit_.IsAtMost(T_local_vehicle.translation_m, fit + above), above > 0.0);
  }
}

TYPED_TEST(MapFitTest, IsTheSameAtAHeadingOfItsOwn) {
  constexpr int kSize = TypeParam::value;
  constexpr double kTurn_rad = 0.2;
  Pose3 turn;
  turn.rotation = Eigen::AngleAxisd(kTurn_rad, Eigen::Vector3d::UnitZ());
  Pose<kSize> turned;
  if constexpr (kSize == 2) turned.yaw_rad = kTurn_rad;
  if constexpr (kSize == 3) turned = turn;
  this->fit_.Begin(this->live_, this->map_, this->gates_, turned, 0.3);
  const double fit = this->fit_.At(turned.translation_m);
  this->fit_.Begin(this->live_, this->map_, this->gates_, {}, 0.3);
  EXPECT_NEAR(this->fit_.At(turned.translation_m, kTurn_rad), fit, 1e-4);
  EXPECT_GT(std::abs(this->fit_.At(turned.translation_m) - fit), 1e-3);
}

TYPED_TEST(MapFitTest, IsHighestWhereThePointsWereSeen) {
  constexpr int kSize = TypeParam::value;
  const LocalMap<kSize> map(Pose3(), this->live_);
  this->fit_.Begin(this->live_, map, this->gates_, {}, 0.0);
  PointVector<kSize> aside_m = PointVector<kSize>::Zero();
  const double here = this->fit_.At(aside_m);
  aside_m.y() = 0.5;
  EXPECT_GT(here, 0.9);
  EXPECT_LT(this->fit_.At(aside_m), here);
}

TYPED_TEST(MapFitTest, IsZeroWithoutPointsOrMap) {
  constexpr int kSize = TypeParam::value;
  this->fit_.Begin({}, this->map_, this->gates_, {}, 0.3);
  EXPECT_EQ(this->fit_.At(PointVector<kSize>::Zero()), 0.0);
  const LocalMap<kSize> nowhere;
  this->fit_.Begin(this->live_, nowhere, this->gates_, {}, 0.3);
  EXPECT_EQ(this->fit_.At(PointVector<kSize>::Zero()), 0.0);
}

}  // namespace
}  // namespace dcloc
