#include "core/odometry/odometry_errors.h"

#include <gtest/gtest.h>

#include <chrono>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

// Drives straight on by wheels that are right; the motion is that of the scale in use.
void DriveStraight(OdometryErrors& errors, int steps) {
  Pose3 truth;
  for (int i = 0; i < steps; ++i) {
    Pose3 moved;
    moved.translation_m.x() = 1.0 * errors.in_use().scale();
    errors.OnMotion(moved, milliseconds(100), OdometryErrorFilter::SpeedOrigin::kWheels);
    truth.translation_m.x() += 1.0;
    if (i % 10 == 9) errors.OnPose(truth, 1e-4 * Eigen::Matrix3d::Identity());
  }
}

TEST(OdometryErrorsTest, WithoutDopplersWordThereIsOneFilter) {
  OdometryErrors errors({});
  DriveStraight(errors, 50);
  EXPECT_FALSE(errors.without_doppler());
  EXPECT_EQ(&errors.in_use(), &errors.by_doppler());
}

TEST(OdometryErrorsTest, AChangeIsDopplersWordUntilItIsCertain) {
  OdometryErrors errors({});
  errors.OnDopplersScaleChange({.value = 0.07, .variance = 1e-4});
  errors.OnDopplersSoundness(/*is_sound=*/true, /*is_certain=*/false);
  EXPECT_NEAR(errors.in_use().scale(), 1.07, 1e-9);
  errors.OnDopplersSoundness(/*is_sound=*/false, /*is_certain=*/false);
  EXPECT_NEAR(errors.in_use().scale(), 1.0, 1e-9);
  errors.OnDopplersSoundness(/*is_sound=*/true, /*is_certain=*/true);
  EXPECT_NEAR(errors.in_use().scale(), 1.07, 1e-9);
  EXPECT_FALSE(errors.without_doppler());
}

TEST(OdometryErrorsTest, WhatDopplerSaidIsGoneWithDoppler) {
  OdometryErrors errors({});
  errors.OnDopplersScale({.value = 1.07, .variance = 1e-5});
  errors.OnDopplersSoundness(/*is_sound=*/false, /*is_certain=*/true);
  errors.OnDopplersSoundness(/*is_sound=*/true, /*is_certain=*/true);
  EXPECT_NEAR(errors.in_use().scale(), 1.0, 1e-9);
}

TEST(OdometryErrorsTest, BothLearnFromPosesWhicheverIsInUse) {
  for (const bool uses_doppler : {true, false}) {
    OdometryErrors errors({});
    errors.OnDopplersScaleChange({.value = 0.05, .variance = 4e-4});
    errors.OnDopplersSoundness(uses_doppler, /*is_certain=*/false);
    DriveStraight(errors, 600);
    EXPECT_NEAR(errors.by_doppler().scale(), 1.0, 0.01) << uses_doppler;
    EXPECT_NEAR(errors.without_doppler()->scale(), 1.0, 0.005) << uses_doppler;
  }
}

}  // namespace
}  // namespace dcloc
