#include "core/registration/point_matches.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>
#include <type_traits>

#include "tests/core/registration/point_clouds.h"

namespace dcloc {
namespace {

template <typename Dimension>
class PointMatchesTest : public ::testing::Test {};

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(PointMatchesTest, Dimensions);

template <int Dim>
std::vector<GaussianPoint<Dim>> Crowd(int count, double half_m, double sigma_m,
                                      std::mt19937& random) {
  std::vector<GaussianPoint<Dim>> points;
  for (const PointVector<Dim>& p : SeparatedPoints<Dim>(count, half_m, 0.05, random)) {
    points.push_back({p, RandomCovariance<Dim>(sigma_m, random)});
  }
  return points;
}

// Every landmark looked at for every live point, by the definition.
template <int Dim>
std::vector<PointMatch<Dim>> AllMatches(const std::vector<GaussianPoint<Dim>>& live,
                                        const LocalMap<Dim>& map, const Pose<Dim>& T, double blur_m,
                                        const MatchGates& gates) {
  std::vector<PointMatch<Dim>> matches;
  const PointMatrix<Dim> R = T.Rotation();
  for (const GaussianPoint<Dim>& point : live) {
    double best = std::numeric_limits<double>::infinity();
    PointMatch<Dim> match;
    for (const GaussianPoint<Dim>& landmark : map.points()) {
      const PointVector<Dim> e = landmark.mean_m - (R * point.mean_m + T.translation_m);
      const PointMatrix<Dim> joint = landmark.covariance_m2 +
                                     R * point.covariance_m2 * R.transpose() +
                                     blur_m * blur_m * PointMatrix<Dim>::Identity();
      const double distance = e.dot(joint.inverse() * e);
      if (e.norm() > gates.reach_m || distance > std::pow(gates.gate_sigmas, 2)) continue;
      const double cost = distance + std::log(joint.determinant());
      if (cost >= best) continue;
      best = cost;
      match = {point.mean_m, landmark.mean_m, joint.inverse()};
    }
    if (std::isfinite(best)) matches.push_back(match);
  }
  return matches;
}

TYPED_TEST(PointMatchesTest, AreTheMostLikelyLandmarksWhereverThePoseHasMoved) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(1);
  const LocalMap<kDim> map({}, Crowd<kDim>(1500, 20.0, 0.3, random));
  const auto live = Crowd<kDim>(150, 18.0, 0.3, random);
  const MatchGates gates{.reach_m = 2.0, .gate_sigmas = 3.0};
  MatchFinder<kDim> finder;
  finder.Begin(live, map, gates);
  Pose<kDim> T = SmallMotion<kDim>(0.5, 0.2);
  // Steps like a registration's: large ones that leave the neighbourhood, ever smaller ones that
  // stay in it, with and without blur.
  double step_m = 0.6;
  double blur_m = 0.4;
  std::size_t different = 0;
  for (int step = 0; step < 24; ++step) {
    const auto truth = AllMatches<kDim>(live, map, T, blur_m, gates);
    const auto found = finder.Find(T, blur_m);
    ASSERT_EQ(found.size(), truth.size()) << "step " << step;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].p, truth[i].p);
      different += found[i].q == truth[i].q ? 0 : 1;
      EXPECT_LT((found[i].information - truth[i].information).norm(),
                1e-9 * truth[i].information.norm());
    }
    T = T * SmallMotion<kDim>(step % 2 == 0 ? step_m : -0.7 * step_m, 0.02 * step_m);
    step_m *= 0.8;
    if (step % 4 == 3) blur_m = blur_m > 0.05 ? 0.5 * blur_m : 0.0;
  }
  EXPECT_EQ(different, 0U);
}

TYPED_TEST(PointMatchesTest, ANewSubmapForgetsTheLastOne) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(2);
  const LocalMap<kDim> map({}, Crowd<kDim>(200, 20.0, 0.3, random));
  const auto first = Crowd<kDim>(50, 18.0, 0.3, random);
  const auto second = Crowd<kDim>(80, 18.0, 0.3, random);
  MatchFinder<kDim> finder;
  finder.Begin(first, map, {});
  finder.Find({}, 0.0);
  finder.Begin(second, map, {});
  const auto truth = AllMatches<kDim>(second, map, {}, 0.0, {});
  EXPECT_EQ(finder.Find({}, 0.0).size(), truth.size());
  EXPECT_GT(truth.size(), 10U);
}

TYPED_TEST(PointMatchesTest, WhatIsNotANumberMatchesNothing) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(3);
  auto landmarks = Crowd<kDim>(100, 10.0, 0.3, random);
  const auto live = landmarks;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  landmarks[7].covariance_m2(0, 0) = nan;
  landmarks[8].covariance_m2.setZero();
  landmarks[9].covariance_m2 *= -1.0;
  const LocalMap<kDim> map({}, landmarks);
  MatchFinder<kDim> finder;
  finder.Begin(live, map, {});
  for (const PointMatch<kDim>& match : finder.Find({}, 0.0)) {
    EXPECT_TRUE(match.information.allFinite());
  }
  Pose<kDim> nowhere;
  nowhere.translation_m.setConstant(nan);
  EXPECT_TRUE(finder.Find(nowhere, 0.0).empty());
}

}  // namespace
}  // namespace dcloc
