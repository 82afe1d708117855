#include "core/registration/radial_statistics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using Vector2fs = std::vector<Eigen::Vector2f>;

Vector2fs Scattered(int count, float half_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place_m(-half_m, half_m);
  Vector2fs points;
  for (int i = 0; i < count; ++i) points.emplace_back(place_m(random), place_m(random));
  return points;
}

TEST(RadialStatisticsOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<RadialStatisticsOptions>();
}

TEST(RadialStatisticsTest, TurnsAndShiftsChangeNothing) {
  const Vector2fs points = Scattered(60, 30.0F, 1);
  Vector2fs moved;
  const Eigen::Rotation2Df turn(2.2F);
  for (const Eigen::Vector2f& point : points) {
    moved.emplace_back(turn * point + Eigen::Vector2f(17.0F, -40.0F));
  }
  const Eigen::MatrixXf a = RadialStatistics(points);
  const Eigen::MatrixXf b = RadialStatistics(moved);
  ASSERT_EQ(a.cols(), 60);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-3F);
  // But another point's column is another.
  EXPECT_GT((a.col(0) - a.col(1)).norm(), 0.5F);
}

// Each distance spread over the two nearest multiples of the bin, as the area of a triangle says.
Eigen::VectorXd HistogramByHand(const Vector2fs& points, std::size_t of,
                                const RadialStatisticsOptions& options, Eigen::Index bins) {
  Eigen::VectorXd histogram = Eigen::VectorXd::Zero(bins);
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (j == of) continue;
    const double distance_m = (points[j] - points[of]).cast<double>().norm();
    for (Eigen::Index bin = 0; bin < bins; ++bin) {
      const double away = std::abs(distance_m / options.bin_m - static_cast<double>(bin));
      histogram(bin) += std::max(0.0, 1.0 - away);
    }
  }
  const double min = histogram.minCoeff();
  return (histogram.array() - min) / (histogram.maxCoeff() - min);
}

TEST(RadialStatisticsTest, IsTheScaledHistogramOfTheDistances) {
  // All distances lie below the largest: its border is the implementation's own.
  const Vector2fs points = Scattered(25, 10.0F, 2);
  for (const double bin_m : {1.0 / 3.0, 1.0}) {
    const RadialStatisticsOptions options{.bin_m = bin_m, .max_distance_m = 40.0};
    const Eigen::MatrixXf descriptors = RadialStatistics(points, options);
    ASSERT_GE(descriptors.rows(), static_cast<Eigen::Index>(40.0 / bin_m));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::VectorXd truth = HistogramByHand(points, i, options, descriptors.rows());
      const auto column = static_cast<Eigen::Index>(i);
      EXPECT_LT((descriptors.col(column).cast<double>() - truth).cwiseAbs().maxCoeff(), 1e-4);
    }
  }
}

TEST(RadialStatisticsTest, WhatIsFurtherThanTheLargestDistanceDoesNotCount) {
  Vector2fs points = Scattered(20, 8.0F, 3);
  const RadialStatisticsOptions options{.max_distance_m = 30.0};
  const Eigen::MatrixXf before = RadialStatistics(points, options);
  points.emplace_back(100.0F, 0.0F);
  const Eigen::MatrixXf after = RadialStatistics(points, options);
  EXPECT_EQ(before, after.leftCols(20));
  EXPECT_EQ(after.col(20).norm(), 0.0F);
}

TEST(RadialStatisticsTest, ASmallShiftOfAPointChangesItLittle) {
  Vector2fs points = Scattered(40, 20.0F, 4);
  const Eigen::MatrixXf before = RadialStatistics(points);
  points[0] += Eigen::Vector2f(0.03F, 0.0F);
  const Eigen::MatrixXf after = RadialStatistics(points);
  EXPECT_LT((before.col(0) - after.col(0)).norm(), 0.3F * before.col(0).norm());
}

TEST(RadialStatisticsTest, ValuesLieInTheUnitRangeAndFewPointsAreFine) {
  EXPECT_EQ(RadialStatistics({}).cols(), 0);
  EXPECT_EQ(RadialStatistics(Vector2fs{{1.0F, 2.0F}}).norm(), 0.0F);
  const Eigen::MatrixXf same = RadialStatistics(Vector2fs(3, Eigen::Vector2f(1.0F, 2.0F)));
  EXPECT_TRUE(same.allFinite());
  const Eigen::MatrixXf many = RadialStatistics(Scattered(50, 20.0F, 5));
  EXPECT_EQ(many.minCoeff(), 0.0F);
  EXPECT_EQ(many.maxCoeff(), 1.0F);
}

// How many columns of `of` are nearer to `column` than its column `index` is.
int Rank(const Eigen::MatrixXf& of, const Eigen::VectorXf& column, Eigen::Index index) {
  const double own = (of.col(index) - column).cast<double>().squaredNorm();
  int nearer = 0;
  for (Eigen::Index i = 0; i < of.cols(); ++i) {
    nearer += (of.col(i) - column).cast<double>().squaredNorm() < own;
  }
  return nearer;
}

TEST(MutualNearestTest, AgreesWithLookingAtEveryPair) {
  std::srand(6);
  const Eigen::MatrixXf a = Eigen::MatrixXf::Random(12, 70);
  const Eigen::MatrixXf b = Eigen::MatrixXf::Random(12, 45);
  for (const int k : {1, 2}) {
    std::vector<std::pair<std::size_t, std::size_t>> truth;
    for (Eigen::Index i = 0; i < a.cols(); ++i) {
      for (Eigen::Index j = 0; j < b.cols(); ++j) {
        if (Rank(b, a.col(i), j) >= k || Rank(a, b.col(j), i) >= k) continue;
        truth.emplace_back(i, j);
      }
    }
    const std::vector<IndexPair> pairs = MutualNearest(a, b, k);
    EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end(),
                               [](const auto& x, const auto& y) { return x.a < y.a; }));
    std::vector<std::pair<std::size_t, std::size_t>> found;
    found.reserve(pairs.size());
    for (const IndexPair& pair : pairs) found.emplace_back(pair.a, pair.b);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, truth) << "k = " << k;
    EXPECT_GT(found.size(), 10U);
  }
}

TEST(MutualNearestTest, FewColumnsAndNone) {
  const Eigen::MatrixXf a = Eigen::MatrixXf::Identity(3, 3);
  EXPECT_TRUE(MutualNearest(a, Eigen::MatrixXf(3, 0)).empty());
  EXPECT_TRUE(MutualNearest(Eigen::MatrixXf(3, 0), a).empty());
  EXPECT_EQ(MutualNearest(a, a).size(), 3U);
  // More neighbours than there are columns: all pairs.
  EXPECT_EQ(MutualNearest(a, a, 10).size(), 9U);
}

}  // namespace
}  // namespace dcloc
