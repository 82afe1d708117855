#include "core/registration/correspondences.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
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
  points.reserve(static_cast<std::size_t>(count));
  for (const PointVector<Dim>& p : SeparatedPoints<Dim>(count, half_m, 0.05, random)) {
    points.push_back({p, RandomCovariance<Dim>(sigma_m, random)});
  }
  return points;
}

// The same, live, seen from the origin by a planar radar.
template <int Dim>
std::vector<GaussianPoint<Dim>> Seen(std::vector<GaussianPoint<Dim>> points) {
  for (auto& point : points) {
    point.slant_per_m = point.mean_m / (2.0 * std::max(1.0, point.mean_m.squaredNorm()));
  }
  return points;
}

// The same as landmarks between 0 and 3 m high.
template <int Dim>
std::vector<GaussianPoint<Dim>> Raised(std::vector<GaussianPoint<Dim>> points,
                                       std::mt19937& random) {
  std::uniform_real_distribution<double> height_m(0.0, 3.0);
  for (auto& point : points) point.height_square_m2 = std::pow(height_m(random), 2);
  return points;
}

// Where the landmark lies for the point: a height moves the point, and so its match.
template <int Dim>
PointVector<Dim> MatchOf(const GaussianPoint<Dim>& point, const PackedPoint<Dim>& landmark,
                         const Pose<Dim>& T) {
  return landmark.SeenBy(PointVector<Dim>(T.Rotation() * point.slant_per_m));
}

// What a pair costs by the definition, or nothing when it does not pass the gates.
template <int Dim>
std::optional<double> CostOf(const GaussianPoint<Dim>& point, const PackedPoint<Dim>& landmark,
                             const Pose<Dim>& T, double blur_m, const CorrespondenceGates& gates) {
  const PointMatrix<Dim> R = T.Rotation();
  const PointVector<Dim> e =
      MatchOf<Dim>(point, landmark, T) - (R * point.mean_m + T.translation_m);
  const PointMatrix<Dim> joint = landmark.Covariance_m2() +
                                 R * point.covariance_m2 * R.transpose() +
                                 blur_m * blur_m * PointMatrix<Dim>::Identity();
  const double distance = e.dot(joint.inverse() * e);
  if (e.norm() > gates.max_distance_m || distance > std::pow(gates.gate_sigmas, 2))
    return std::nullopt;
  return distance + std::log(joint.determinant());
}

// Every landmark looked at.
template <int Dim>
std::optional<double> LeastCost(const GaussianPoint<Dim>& point, const LocalMap<Dim>& map,
                                const Pose<Dim>& T, double blur_m,
                                const CorrespondenceGates& gates) {
  std::optional<double> least;
  for (const PackedPoint<Dim>& landmark : map.points()) {
    const auto cost = CostOf<Dim>(point, landmark, T, blur_m, gates);
    if (cost && (!least || *cost < *least)) least = cost;
  }
  return least;
}

template <int Dim>
const PackedPoint<Dim>& LandmarkOf(const GaussianPoint<Dim>& point, const LocalMap<Dim>& map,
                                   const Pose<Dim>& T, const PointVector<Dim>& q) {
  return *std::ranges::min_element(map.points(), {}, [&](const auto& landmark) {
    return (MatchOf<Dim>(point, landmark, T) - q).norm();
  });
}

TYPED_TEST(PointMatchesTest, AreTheMostLikelyLandmarksWhereverThePoseHasMoved) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(1);
  const LocalMap<kDim> map({}, Raised<kDim>(Crowd<kDim>(1500, 20.0, 0.3, random), random));
  const auto live = Seen<kDim>(Crowd<kDim>(150, 18.0, 0.3, random));
  const CorrespondenceGates gates{.max_distance_m = 2.0, .gate_sigmas = 3.0};
  // Pairs at the very edge of a gate may fall to either side of it.
  const CorrespondenceGates tighter{.max_distance_m = 1.999, .gate_sigmas = 2.99};
  const CorrespondenceGates looser{.max_distance_m = 2.001, .gate_sigmas = 3.01};
  CorrespondenceFinder<kDim> finder;
  finder.Begin(live, map, gates);
  Pose<kDim> T = SmallMotion<kDim>(0.5, 0.2);
  // Steps like a registration's: large ones that leave the neighbourhoods, ever smaller ones that
  // stay in them, with and without blur.
  double step_m = 0.6;
  double blur_m = 0.4;
  for (int step = 0; step < 30; ++step) {
    const auto found = finder.Find(T, blur_m);
    EXPECT_GT(found.size(), live.size() / 2);
    auto match = found.begin();
    for (const GaussianPoint<kDim>& point : live) {
      if (match == found.end() || match->p != point.mean_m) {
        EXPECT_FALSE(LeastCost<kDim>(point, map, T, blur_m, tighter)) << "step " << step;
        continue;
      }
      const PackedPoint<kDim>& landmark = LandmarkOf<kDim>(point, map, T, match->q);
      // Turned a milliradian before, like the weights.
      EXPECT_LT((match->q - MatchOf<kDim>(point, landmark, T)).norm(), 0.005);
      const auto cost = CostOf<kDim>(point, landmark, T, blur_m, looser);
      ASSERT_TRUE(cost) << "step " << step;
      // The weights were turned a milliradian before.
      const auto least = LeastCost<kDim>(point, map, T, blur_m, tighter);
      EXPECT_TRUE(!least || *cost < *least + 0.05) << "step " << step;
      const PointMatrix<kDim> R = T.Rotation();
      const PointMatrix<kDim> joint = landmark.Covariance_m2() +
                                      R * point.covariance_m2 * R.transpose() +
                                      blur_m * blur_m * PointMatrix<kDim>::Identity();
      EXPECT_LT((match->information * joint - PointMatrix<kDim>::Identity()).norm(), 0.02);
      ++match;
    }
    EXPECT_EQ(match, found.end());
    T = T * SmallMotion<kDim>(step % 2 == 0 ? step_m : -0.7 * step_m, 0.03 * step_m);
    step_m *= 0.8;
    if (step % 4 == 3) blur_m = blur_m > 0.05 ? 0.5 * blur_m : 0.0;
  }
}

TYPED_TEST(PointMatchesTest, ANewSubmapForgetsTheLastOne) {
  constexpr int kDim = TypeParam::value;
  std::mt19937 random(2);
  const LocalMap<kDim> map({}, Crowd<kDim>(200, 20.0, 0.3, random));
  const auto first = Crowd<kDim>(50, 18.0, 0.3, random);
  const auto second = Crowd<kDim>(80, 18.0, 0.3, random);
  CorrespondenceFinder<kDim> finder;
  finder.Begin(first, map, {});
  finder.Find({}, 0.0);
  finder.Begin(second, map, {});
  CorrespondenceFinder<kDim> fresh;
  fresh.Begin(second, map, {});
  const auto truth = fresh.Find({}, 0.0);
  const auto found = finder.Find({}, 0.0);
  ASSERT_EQ(found.size(), truth.size());
  EXPECT_GT(truth.size(), 10U);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].q, truth[i].q);
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
  CorrespondenceFinder<kDim> finder;
  finder.Begin(live, map, {});
  for (const Correspondence<kDim>& match : finder.Find({}, 0.0)) {
    EXPECT_TRUE(match.information.allFinite());
  }
  Pose<kDim> nowhere;
  nowhere.translation_m.setConstant(nan);
  EXPECT_TRUE(finder.Find(nowhere, 0.0).empty());
}

}  // namespace
}  // namespace dcloc
