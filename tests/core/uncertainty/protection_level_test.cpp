#include "core/uncertainty/protection_level.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dcloc {
namespace {

TEST(ProtectionLevelTest, GrowsWithTheLongestHalfAxis) {
  Matrix6d covariance = Matrix6d::Identity();
  covariance(0, 0) = covariance(1, 1) = 0.5 * (0.01 + 0.0004);
  covariance(0, 1) = covariance(1, 0) = 0.5 * (0.01 - 0.0004);  // 0.1 m along a diagonal
  EXPECT_NEAR(ProtectionLevel({}).Of(covariance), 0.15 + 4.29 * 0.1, 1e-9);
}

TEST(ProtectionLevelTest, GrowsWithInnovationsThatTheCovarianceDoesNotExplain) {
  ProtectionLevel level({});
  const Matrix6d covariance = 0.01 * Matrix6d::Identity();
  const double usual_m = level.Of(covariance);
  for (int i = 0; i < 100; ++i) level.OnInnovation(0.2, Eigen::Vector2d::Zero());
  EXPECT_NEAR(level.Of(covariance), usual_m, 1e-9) << "small innovations promise nothing more";
  for (int i = 0; i < 100; ++i) level.OnInnovation(4.0, Eigen::Vector2d::Zero());
  EXPECT_NEAR(level.Of(covariance), 0.15 + 4.29 * 0.2, 1e-2);
  level.OnInnovation(1e12, Eigen::Vector2d::Zero());
  EXPECT_LT(level.Of(covariance), 2.0);
}

TEST(ProtectionLevelTest, GrowsByHowFarRegistrationsLieToOneSide) {
  ProtectionLevel level({});
  const Matrix6d covariance = 0.01 * Matrix6d::Identity();
  const double usual_m = level.Of(covariance);
  for (int i = 0; i < 100; ++i) level.OnInnovation(0.2, {i % 2 == 0 ? 0.2 : -0.2, 0.0});
  EXPECT_NEAR(level.Of(covariance), usual_m, 0.03) << "to both sides";
  for (int i = 0; i < 100; ++i) level.OnInnovation(0.2, {0.0, -0.2});
  EXPECT_NEAR(level.Of(covariance), usual_m + 0.2, 1e-3);
}

TEST(ProtectionLevelTest, HoldsByHowMuchAPoseWasMovedForSomeOfTheWay) {
  ProtectionLevel level({});
  const Matrix6d covariance = 0.01 * Matrix6d::Identity();
  const double usual_m = level.Of(covariance);
  EXPECT_DOUBLE_EQ(level.Usual(covariance), usual_m);
  level.OnContradiction(0.9);
  EXPECT_NEAR(level.Of(covariance), usual_m + 0.9, 1e-9);
  level.OnContradiction(0.5);
  EXPECT_NEAR(level.Of(covariance), usual_m + 1.4, 1e-9) << "twice moved";
  for (int i = 0; i < 150; ++i) level.OnMotion(1.0);
  EXPECT_NEAR(level.Of(covariance), usual_m + 1.4 / std::exp(1.0), 1e-9);
  EXPECT_DOUBLE_EQ(level.Usual(covariance), usual_m);
  level.OnContradiction(100.0);
  EXPECT_NEAR(level.Of(covariance), usual_m + 2.0, 1e-9) << "another place";
}

}  // namespace
}  // namespace dcloc
