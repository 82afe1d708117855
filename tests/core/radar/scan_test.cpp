#include "core/radar/scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dcloc {
namespace {

using ::testing::HasSubstr;

Scan TwoTargets() {
  Scan scan;
  scan.range_m = {10.0F, 20.0F};
  scan.range_rate_mps = {-1.0F, 2.0F};
  scan.azimuth_rad = {0.1F, -0.2F};
  return scan;
}

TEST(ValidateScanTest, AcceptsAScanAndAnEmptyOne) {
  EXPECT_TRUE(Validate(TwoTargets()).ok());
  EXPECT_TRUE(Validate(Scan{}).ok());
}

TEST(ValidateScanTest, NamesTheColumnOfUnequalLength) {
  Scan scan = TwoTargets();
  scan.azimuth_rad.pop_back();
  EXPECT_THAT(Validate(scan).message(), HasSubstr("azimuth_rad has 1 values; range_m has 2"));
  scan = TwoTargets();
  scan.rcs_dbsm = {1.0F};
  EXPECT_THAT(Validate(scan).message(), HasSubstr("rcs_dbsm has 1 values"));
}

TEST(ValidateScanTest, NamesRowValueAndBound) {
  for (const float bad :
       {0.0F, -3.0F, 1e6F, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    Scan scan = TwoTargets();
    scan.range_m[1] = bad;
    EXPECT_THAT(Validate(scan).message(), HasSubstr("range_m[1] is ")) << bad;
    EXPECT_THAT(Validate(scan).message(), HasSubstr("must lie in [0.001, 1000]")) << bad;
  }
  Scan scan = TwoTargets();
  scan.range_rate_mps[0] = -500.0F;
  EXPECT_THAT(Validate(scan).message(), HasSubstr("range_rate_mps[0] is -500"));
  scan = TwoTargets();
  scan.azimuth_sigma_rad = {0.1F, 0.0F};
  EXPECT_THAT(Validate(scan).message(), HasSubstr("azimuth_sigma_rad[1] is 0"));
  scan.azimuth_sigma_rad = {0.1F, std::numeric_limits<float>::infinity()};
  EXPECT_FALSE(Validate(scan).ok());
}

TEST(ValidateScanTest, RefusesTooManyTargets) {
  EXPECT_THAT(Validate(TwoTargets(), {.max_targets = 1}).message(),
              HasSubstr("range_m has 2 targets; the limit is 1"));
}

TEST(ValidateScanTest, RefusesAbsurdVelocities) {
  Scan scan = TwoTargets();
  scan.ego_velocity = EgoVelocity{.linear_mps = {400.0, 0.0, 0.0}};
  EXPECT_THAT(Validate(scan).message(), HasSubstr("ego_velocity.linear_mps"));
  scan.ego_velocity = EgoVelocity{.angular_radps = {0.0, 0.0, std::nan("")}};
  EXPECT_THAT(Validate(scan).message(), HasSubstr("ego_velocity.angular_radps"));
  scan.ego_velocity = EgoVelocity{.covariance = Matrix6d(-Matrix6d::Identity())};
  EXPECT_THAT(Validate(scan).message(), HasSubstr("ego_velocity.covariance"));
}

}  // namespace
}  // namespace dcloc
