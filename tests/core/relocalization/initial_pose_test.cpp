#include "core/relocalization/initial_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace dcloc {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class InitialPoseTest : public ::testing::Test {
 protected:
  std::string Fault() const { return std::string(Validate(pose_).message()); }

  InitialPose pose_{.T_map_vehicle = {}, .covariance = Matrix6d::Identity()};
};

TEST_F(InitialPoseTest, ACertainOneIsValid) {
  EXPECT_TRUE(Validate(pose_).ok());
  pose_.covariance.setZero();
  EXPECT_TRUE(Validate(pose_).ok());
}

TEST_F(InitialPoseTest, WhatIsNoPoseIsNamed) {
  pose_.T_map_vehicle.translation_m.x() = kNan;
  EXPECT_THAT(Fault(), HasSubstr("initial_pose.T_map_vehicle must be finite"));
  pose_.T_map_vehicle.translation_m.setZero();
  pose_.T_map_vehicle.rotation.coeffs() *= 2.0;
  EXPECT_THAT(Fault(), HasSubstr("a rotation of norm 1"));
}

TEST_F(InitialPoseTest, WhatIsNoCovarianceIsNamed) {
  for (const double variance : {-1.0, kNan}) {
    pose_.covariance(2, 2) = variance;
    EXPECT_THAT(Fault(), HasSubstr("initial_pose.covariance must be finite")) << variance;
  }
}

TEST_F(InitialPoseTest, BeyondTheBoundsItIsRefusedWithTheValue) {
  pose_.T_map_vehicle.translation_m.x() = 2e10;
  EXPECT_THAT(Fault(), HasSubstr("lies 2e+10 m from the map's origin; the limit is 1e+10 m"));
  pose_.T_map_vehicle.translation_m.x() = 0.0;
  pose_.covariance(0, 0) = 1e17;
  EXPECT_THAT(Fault(), HasSubstr("has a variance of 1e+17; the limit is 1e+16"));
}

}  // namespace
}  // namespace dcloc
