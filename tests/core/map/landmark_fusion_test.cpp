#include "core/map/landmark_fusion.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

// A radar's noise: `range_sigma_m` along the line of sight, `across_sigma_m` across it.
Eigen::Matrix3d NoiseSeenFrom(double bearing_rad, double range_sigma_m, double across_sigma_m,
                              double z_sigma_m) {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(bearing_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d sigmas(range_sigma_m, across_sigma_m, z_sigma_m);
  return rotation * sigmas.cwiseAbs2().asDiagonal() * rotation.transpose();
}

class FusionTest : public ::testing::Test {
 protected:
  Eigen::Vector3d Noise(const Eigen::Matrix3d& covariance) {
    const Eigen::Vector3d white(normal_(random_), normal_(random_), normal_(random_));
    return covariance.llt().matrixL() * white;
  }

  // One scan more in which `scatterer` was seen; planar radars report z = 0.
  void See(const Eigen::Vector3d& scatterer, const Eigen::Matrix3d& covariance,
           bool planar = true) {
    Eigen::Vector3d position = scatterer + Noise(covariance);
    if (planar) position.z() = 0.0;
    const Eigen::Matrix3f c = covariance.cast<float>();
    returns_.push_back({.position_m = position,
                        .covariance_m2 = {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)},
                        .rcs_dbsm = 5.0F,
                        .scan = static_cast<std::uint32_t>(pass_of_scan_.size())});
    pass_of_scan_.push_back(pass_);
  }

  std::vector<Landmark> Fuse(FusionOptions options = {}, bool has_elevation = false) const {
    return FuseLandmarks(returns_, pass_of_scan_, has_elevation, options);
  }

  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
  std::vector<MapReturn> returns_;
  std::vector<std::uint32_t> pass_of_scan_;
  std::uint32_t pass_ = 0;
};

TEST(FusionOptionsTest, EachFieldIsBounded) { ExpectEachFieldIsBounded<FusionOptions>(); }

TEST_F(FusionTest, NothingGivesNothing) { EXPECT_TRUE(Fuse().empty()); }

TEST_F(FusionTest, ScatterersThatAreApartBecomeOneLandmarkEachWithAShrunkenError) {
  // 100 scatterers 3 m apart at all offsets from any grid, 30 scans of each from all sides.
  std::vector<Eigen::Vector3d> scatterers;
  for (int i = 0; i < 100; ++i) {
    const int row = i / 10;
    scatterers.emplace_back(1e6 + 3.1 * (i % 10), -1e6 + 3.1 * row, 0.0);
    for (int scan = 0; scan < 30; ++scan) {
      See(scatterers.back(), NoiseSeenFrom(0.2 * scan, 0.15, 0.3, 1.0));
    }
  }
  const std::vector<Landmark> landmarks = Fuse({.min_scan_count = 10});
  ASSERT_EQ(landmarks.size(), scatterers.size());
  double squared_m2 = 0.0;
  double nees = 0.0;
  for (const Eigen::Vector3d& scatterer : scatterers) {
    const Landmark* nearest = &landmarks.front();
    for (const Landmark& landmark : landmarks) {
      if ((landmark.position_m - scatterer).norm() < (nearest->position_m - scatterer).norm()) {
        nearest = &landmark;
      }
    }
    const Eigen::Vector2d error_m = (nearest->position_m - scatterer).head<2>();
    squared_m2 += error_m.squaredNorm() / 100.0;
    nees += error_m.dot(nearest->covariance_m2.topLeftCorner<2, 2>().inverse() * error_m) / 200.0;
  }
  // One return is off by hypot(0.15, 0.3) = 0.34 m; thirty by 0.06 m, and a gate may cost a little.
  EXPECT_LT(std::sqrt(squared_m2), 0.09);
  // Per degree of freedom; the floor makes it conservative, as it should be.
  EXPECT_LT(nees, 1.0);
  EXPECT_GT(nees, 0.1);
}

TEST_F(FusionTest, TheCovarianceIsTheScatterersOwnSpread) {
  // Extended scatterers: returns come from anywhere within 0.3 m (standard deviation) along x.
  Eigen::Matrix2d mean_covariance = Eigen::Matrix2d::Zero();
  const int count = 50;
  for (int i = 0; i < count; ++i) {
    for (int scan = 0; scan < 60; ++scan) {
      const Eigen::Vector3d reflection(20.0 * i + 0.3 * normal_(random_), 0.0, 0.0);
      See(reflection, NoiseSeenFrom(0.1 * scan, 0.1, 0.1, 1.0));
    }
  }
  const std::vector<Landmark> landmarks = Fuse({.cell_m = 1.2, .min_scan_count = 30});
  ASSERT_EQ(landmarks.size(), static_cast<std::size_t>(count));
  for (const Landmark& landmark : landmarks) {
    mean_covariance += landmark.covariance_m2.topLeftCorner<2, 2>() / count;
  }
  // The gate at two standard deviations leaves out the far tails.
  EXPECT_NEAR(std::sqrt(mean_covariance(0, 0)), 0.3, 0.06);
  EXPECT_LT(std::sqrt(mean_covariance(1, 1)), 0.12);
  EXPECT_NEAR(mean_covariance(0, 1), 0.0, 0.01);
}

TEST_F(FusionTest, ScattererWithinReachOfEachOtherStayApartWhenTheMeasurementsTellThemApart) {
  for (int scan = 0; scan < 40; ++scan) {
    See({0.0, 0.0, 0.0}, NoiseSeenFrom(0.1 * scan, 0.1, 0.1, 1.0));
    See({0.9, 0.0, 0.0}, NoiseSeenFrom(0.1 * scan, 0.1, 0.1, 1.0));
  }
  const std::vector<Landmark> landmarks = Fuse({.min_scan_count = 20});
  ASSERT_EQ(landmarks.size(), 2U);
  EXPECT_NEAR(std::abs(landmarks[0].position_m.x() - landmarks[1].position_m.x()), 0.9, 0.08);
}

TEST_F(FusionTest, FarReturnsJoinTheLandmarkThatNearOnesFounded) {
  for (int scan = 0; scan < 20; ++scan) {
    See({0.0, 0.0, 0.0}, NoiseSeenFrom(0.0, 0.15, 1.2, 3.0));   // from 70 m
    See({0.0, 0.0, 0.0}, NoiseSeenFrom(1.5, 0.15, 0.15, 0.5));  // from 8 m
  }
  const std::vector<Landmark> landmarks = Fuse({.min_scan_count = 15});
  ASSERT_EQ(landmarks.size(), 1U);
  EXPECT_LT(landmarks[0].position_m.head<2>().norm(), 0.1);
  EXPECT_LT(std::sqrt(landmarks[0].covariance_m2(1, 1)), 0.25);
}

TEST_F(FusionTest, WithoutElevationTheHeightStaysUncertainAndDoesNotSeparate) {
  for (int scan = 0; scan < 50; ++scan) {
    See({5.0, 5.0, 2.0}, NoiseSeenFrom(0.1 * scan, 0.1, 0.1, 2.0));
    returns_.back().position_m.z() = 0.02 * scan;  // the road rises by a metre
  }
  const std::vector<Landmark> landmarks = Fuse();
  ASSERT_EQ(landmarks.size(), 1U);
  EXPECT_NEAR(landmarks[0].position_m.z(), 0.49, 0.02);
  EXPECT_NEAR(landmarks[0].covariance_m2(2, 2), 4.0, 0.1);
}

TEST_F(FusionTest, WithElevationHeightsSeparateAndAverage) {
  for (int scan = 0; scan < 50; ++scan) {
    See({5.0, 5.0, 0.5}, NoiseSeenFrom(0.1 * scan, 0.1, 0.1, 0.2), /*planar=*/false);
    See({5.0, 5.0, 3.5}, NoiseSeenFrom(0.1 * scan, 0.1, 0.1, 0.2), /*planar=*/false);
  }
  const std::vector<Landmark> landmarks = Fuse({.min_scan_count = 20}, true);
  ASSERT_EQ(landmarks.size(), 2U);
  const auto [low, high] = std::minmax(landmarks[0].position_m.z(), landmarks[1].position_m.z());
  EXPECT_NEAR(low, 0.5, 0.12);
  EXPECT_NEAR(high, 3.5, 0.12);
  EXPECT_LT(landmarks[0].covariance_m2(2, 2), 0.02);
}

// A planar radar drives past along x and sees `scatterer` from 60 m on, at slant ranges.
class HeightTest : public FusionTest {
 protected:
  void DriveBy(const Eigen::Vector3d& scatterer, double range_sigma_m) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d sight = scatterer - Eigen::Vector3d(scatterer.x() - 60.0 + i, 0.0, 0.0);
      const Eigen::Vector2d u = sight.head<2>().normalized();
      const double range_m = sight.norm();
      const Eigen::Vector3d seen =
          scatterer + (range_m - sight.head<2>().norm()) * Eigen::Vector3d(u.x(), u.y(), 0.0);
      See(seen, NoiseSeenFrom(std::atan2(u.y(), u.x()), range_sigma_m, 0.003 * range_m, 0.5));
      const Eigen::Vector2f slant_per_m = (u / (2.0 * range_m)).cast<float>();
      returns_.back().slant_per_m = {slant_per_m.x(), slant_per_m.y()};
    }
  }
};

TEST_F(HeightTest, ComesFromSlantRangesWhichThenNoLongerMoveTheLandmark) {
  const Eigen::Vector3d lamp(0.0, 4.0, 3.0);
  DriveBy(lamp, 0.05);
  const auto with = Fuse();
  const auto without = Fuse({.height_square_sigma_m2 = 0.0});
  ASSERT_EQ(with.size(), 1U);
  ASSERT_EQ(without.size(), 1U);
  EXPECT_NEAR(with[0].height_m, 3.0, 0.5);
  EXPECT_EQ(without[0].height_m, 0.0);
  EXPECT_LT((with[0].position_m - lamp).head<2>().norm(), 0.06);
  EXPECT_GT((without[0].position_m - lamp).head<2>().norm(), 0.12);
  EXPECT_LT(with[0].covariance_m2.trace(), without[0].covariance_m2.trace());
}

TEST_F(HeightTest, OfWhatIsAsHighAsTheRadarIsSmall) {
  const Eigen::Vector3d post(0.0, 4.0, 0.0);
  DriveBy(post, 0.05);
  const auto landmarks = Fuse();
  ASSERT_EQ(landmarks.size(), 1U);
  EXPECT_LT(landmarks[0].height_m, 1.5);
  EXPECT_LT((landmarks[0].position_m - post).head<2>().norm(), 0.05);
}

TEST_F(HeightTest, OfTooFewReturnsIsNotGuessed) {
  DriveBy({0.0, 4.0, 3.0}, 0.05);
  returns_.resize(2);
  const auto landmarks = Fuse();
  ASSERT_EQ(landmarks.size(), 1U);
  EXPECT_EQ(landmarks[0].height_m, 0.0);
}

TEST_F(FusionTest, CountsScansAndPassesAndDropsWhatTooFewSaw) {
  const Eigen::Matrix3d noise = NoiseSeenFrom(0.0, 0.05, 0.05, 1.0);
  See({0.0, 0.0, 0.0}, noise);
  returns_.push_back(returns_.back());  // a second return of the same scan is no second scan
  See({10.0, 0.0, 0.0}, noise);
  See({10.0, 0.0, 0.0}, noise);
  pass_ = 1;
  See({10.0, 0.0, 0.0}, noise);
  const std::vector<Landmark> landmarks = Fuse({.min_scan_count = 2});
  ASSERT_EQ(landmarks.size(), 1U);
  EXPECT_NEAR(landmarks[0].position_m.x(), 10.0, 0.1);
  EXPECT_EQ(landmarks[0].scan_count, 3U);
  EXPECT_EQ(landmarks[0].pass_count, 2U);
  EXPECT_FLOAT_EQ(landmarks[0].rcs_dbsm, 5.0F);
  EXPECT_EQ(Fuse({.min_scan_count = 1}).size(), 2U);
}

}  // namespace
}  // namespace dcloc
