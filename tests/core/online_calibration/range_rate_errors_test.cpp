#include "core/online_calibration/range_rate_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/options/option_fields_check.h"
#include "tests/core/radar/scan_fixture.h"

namespace dcloc {
namespace {

TEST(RangeRateErrorOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<RangeRateErrorOptions>();
}

class RangeRateErrorsTest : public ::testing::Test {
 protected:
  // Gives scans whose range rates are `factor` times the true ones, and shifted; after each, as
  // many registrations are accepted.
  void Drive(double factor, int scans, int registrations_per_scan = 0, double offset_mps = 0.0) {
    for (int i = 0; i < scans; ++i) {
      stamp_ += std::chrono::milliseconds(100);
      Scan scan = StaticScan(radar_, moving_, 60, static_cast<unsigned>(++seed_), 0.05);
      for (float& range_rate_mps : scan.range_rate_mps) {
        range_rate_mps = static_cast<float>(factor * range_rate_mps + offset_mps);
      }
      CorrectRangeRates(errors_.Learned(0), scan);
      const bool is_corrected = std::abs(errors_.Learned(0).scale - factor) < 0.02 &&
                                std::abs(errors_.Learned(0).offset_mps - offset_mps) < 0.1;
      const std::size_t static_count = is_corrected ? 55U : 3U;
      errors_.OnScan(stamp_, 0, scan, static_count, radar_, moving_);
      for (int j = 0; j < registrations_per_scan; ++j) {
        errors_.OnRegistered(stamp_);
      }
    }
  }

  RadarModel radar_ = RadarAt("front", 3.6, 0.0, 0.0);
  const EgoVelocity moving_{.linear_mps = {14.0, 0.0, 0.0},
                            .angular_radps = Eigen::Vector3d::Zero(),
                            .covariance = 1e-4 * Matrix6d::Identity()};
  RangeRateErrors errors_{2, {}};
  Stamp stamp_{std::chrono::seconds(1)};
  int seed_ = 0;
};

TEST_F(RangeRateErrorsTest, AFewScansThatAgreeOnAFactorLetItBeSupposed) {
  Drive(1.3, 2);
  EXPECT_EQ(errors_.Supposed(0).scale, 1.0);
  Drive(1.3, 1);
  EXPECT_NEAR(errors_.Supposed(0).scale, 1.3, 0.02);
  EXPECT_EQ(errors_.Learned(0).scale, 1.0);
  EXPECT_TRUE(errors_.Supposed(1).is_none());
}

TEST_F(RangeRateErrorsTest, WhileNoRadarAgreesTheMotionsComeApart) {
  Drive(1.0, 3);
  EXPECT_EQ(errors_.disputed_distance_m(), 0.0);
  Drive(1.3, 6);
  EXPECT_NEAR(errors_.disputed_distance_m(), 0.3 * 14.0 * 0.5, 0.1);
  Drive(1.3, 20, 1);
  ASSERT_NE(errors_.Learned(0).scale, 1.0);
  EXPECT_EQ(errors_.disputed_distance_m(), 0.0);
}

// Where most of what is seen moves, scans agree with neither motion.
TEST_F(RangeRateErrorsTest, ADisputeThatNoScanContinuesIsOver) {
  Drive(1.3, 2);
  EXPECT_GT(errors_.disputed_distance_m(), 0.0);
  Scan scan = StaticScan(radar_, moving_, 60, 1, 0.05);
  for (std::size_t i = 0; i < scan.size(); ++i) scan.range_rate_mps[i] = i % 3 == 0 ? 9.0F : -3.0F;
  for (int i = 0; i < 21; ++i) {
    stamp_ += std::chrono::milliseconds(100);
    errors_.OnScan(stamp_, 0, scan, 20, radar_, moving_);
  }
  EXPECT_EQ(errors_.disputed_distance_m(), 0.0);
  Drive(1.3, 2);  // a row begins anew
  EXPECT_EQ(errors_.Supposed(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, ADisputeEndsWithThePose) {
  Drive(1.3, 6);
  EXPECT_GT(errors_.disputed_distance_m(), 0.0);
  errors_.OnLost();
  EXPECT_EQ(errors_.disputed_distance_m(), 0.0);
}

TEST_F(RangeRateErrorsTest, ARadarThatOthersContradictDisputesNothing) {
  const Scan scan = StaticScan(radar_, moving_, 60, 1, 0.05);
  errors_.OnScan(stamp_, 1, scan, 55, radar_, moving_);
  Drive(1.3, 6);
  EXPECT_NEAR(errors_.Supposed(0).scale, 1.3, 0.02);
  EXPECT_EQ(errors_.disputed_distance_m(), 0.0);
}

TEST_F(RangeRateErrorsTest, RangeRatesThatAreRightAgainDisputeNothing) {
  for (const double factor : {0.0, 1.3}) {
    errors_ = RangeRateErrors(2, {});
    Drive(factor == 0.0 ? 1e-3 : factor, 20, 1);
    ASSERT_NE(errors_.Learned(0).scale, 1.0);
    const Scan right = StaticScan(radar_, moving_, 60, 1, 0.05);
    Scan corrected = right;
    CorrectRangeRates(errors_.Learned(0), radar_, moving_, corrected);
    for (int i = 0; i < 6; ++i) {
      stamp_ += std::chrono::milliseconds(100);
      errors_.OnScan(stamp_, 0, corrected, 3, radar_, moving_);
    }
    EXPECT_LT(errors_.disputed_distance_m(), 0.2) << factor;
  }
}

TEST_F(RangeRateErrorsTest, RegistrationsForASecondLetItBeLearned) {
  Drive(1.3, 30);
  EXPECT_EQ(errors_.Learned(0).scale, 1.0);  // nothing spoke for the motion it was compared with
  Drive(1.3, 1, 10);
  EXPECT_NE(errors_.Learned(0).scale, 1.0);
  EXPECT_NEAR(errors_.Learned(0).scale, 1.3, 0.02);
  EXPECT_EQ(errors_.Supposed(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, RegistrationsWithinAMomentAreNotEnough) {
  Drive(1.3, 8, 10);
  EXPECT_EQ(errors_.Learned(0).scale, 1.0);
  Drive(1.3, 10, 1);
  EXPECT_NE(errors_.Learned(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, ASignIsAScale) {
  Drive(-1.0, 20, 1);
  EXPECT_NEAR(errors_.Learned(0).scale, -1.0, 0.02);
}

// What stands still has 0, and tells nothing of the motion.
TEST_F(RangeRateErrorsTest, AnOffsetIsToldFromAScale) {
  Drive(1.0, 20, 1, 1.5);
  EXPECT_NEAR(errors_.Learned(0).offset_mps, 1.5, 0.05);
  EXPECT_EQ(errors_.Learned(0).scale, 1.0);
  Drive(1.0, 20, 1, -1.5);
  EXPECT_NEAR(errors_.Learned(0).offset_mps, -1.5, 0.1);
}

// At walking pace, most targets agree with wheels that are off by a tenth, too.
TEST_F(RangeRateErrorsTest, AScaleByWhichNoMoreTargetsAgreeIsNone) {
  EgoVelocity slow = moving_;
  slow.linear_mps.x() = 2.5;
  for (int i = 0; i < 10; ++i) {
    stamp_ += std::chrono::milliseconds(100);
    Scan scan = StaticScan(radar_, slow, 60, static_cast<unsigned>(++seed_), 0.05);
    CorrectRangeRates({.scale = 1.0 / 1.1}, scan);
    EXPECT_FALSE(errors_.OnRegistered(stamp_));
    errors_.OnScan(stamp_, 0, scan, 45, radar_, slow);
  }
  EXPECT_TRUE(errors_.Supposed(0).is_none());
}

TEST_F(RangeRateErrorsTest, CompensatedRangeRatesAreLearnedAndUnlearned) {
  const auto drive = [&](bool is_compensated) {
    for (int i = 0; i < 20; ++i) {
      stamp_ += std::chrono::milliseconds(100);
      Scan scan = StaticScan(radar_, moving_, 60, static_cast<unsigned>(++seed_), 0.05);
      if (is_compensated) std::ranges::fill(scan.range_rate_mps, 0.0F);
      if (!errors_.TellsMotion(0)) AddEgoMotion(radar_, moving_, scan);
      const bool is_right = errors_.TellsMotion(0) != is_compensated;
      errors_.OnScan(stamp_, 0, scan, is_right ? 55U : 3U, radar_, moving_);
      if (i == 5 && is_compensated) {
        EXPECT_EQ(errors_.Supposed(0).scale, kCompensatedScale);
      }
      errors_.OnRegistered(stamp_);
    }
  };
  drive(true);
  EXPECT_EQ(errors_.Learned(0).scale, kCompensatedScale);
  EXPECT_EQ(errors_.Whole(0).scale, kCompensatedScale);
  EXPECT_FALSE(errors_.TellsMotion(0));
  EXPECT_TRUE(errors_.TellsMotion(1));
  drive(false);
  EXPECT_EQ(errors_.Learned(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, WhatCompensationTookOutIsAddedAgain) {
  const Scan measured = StaticScan(radar_, moving_, 60, 1, 0.0);
  Scan scan = measured;
  std::ranges::fill(scan.range_rate_mps, 0.0F);
  CorrectRangeRates({.scale = kCompensatedScale}, radar_, moving_, scan);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(scan.range_rate_mps[i]),
                static_cast<double>(measured.range_rate_mps[i]), 1e-4);
  }
}

TEST_F(RangeRateErrorsTest, AScaleThatEndsIsUnlearned) {
  Drive(1.3, 20, 1);
  ASSERT_NEAR(errors_.Learned(0).scale, 1.3, 0.02);
  Drive(1.0, 20, 1);
  EXPECT_EQ(errors_.Learned(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, OneThatWasNotConfirmedForLongIsForgottenWithThePose) {
  Drive(1.3, 20, 1);
  ASSERT_NE(errors_.Learned(0).scale, 1.0);
  errors_.OnLost();
  EXPECT_EQ(errors_.Learned(0).scale, 1.0);
  Drive(1.3, 150, 1);
  errors_.OnLost();
  EXPECT_NEAR(errors_.Learned(0).scale, 1.3, 0.02);
}

// Wheels that slip are another multiple of Doppler in each scan.
TEST_F(RangeRateErrorsTest, AFactorThatChangesIsNone) {
  for (int i = 0; i < 30; ++i) Drive(1.2 * std::pow(1.03, i), 1);
  EXPECT_EQ(errors_.Supposed(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, AMoverThatFillsTheViewIsNoScale) {
  Scan scan = StaticScan(radar_, moving_, 60, 1, 0.05);
  for (float& azimuth_rad : scan.azimuth_rad) azimuth_rad *= 0.3F;  // all of it straight ahead
  for (float& range_rate_mps : scan.range_rate_mps) range_rate_mps = -18.2F;
  for (int i = 0; i < 10; ++i) errors_.OnScan(stamp_, 0, scan, 0, radar_, moving_);
  EXPECT_EQ(errors_.Supposed(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, AVehicleThatStandsTellsNone) {
  const EgoVelocity standing{.covariance = 1e-4 * Matrix6d::Identity()};
  const Scan scan = StaticScan(radar_, moving_, 60, 1, 0.05);
  for (int i = 0; i < 10; ++i) errors_.OnScan(stamp_, 0, scan, 0, radar_, standing);
  EXPECT_EQ(errors_.Supposed(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, AMultipleOfAliasedRangeRatesIsNotLookedFor) {
  radar_.unambiguous_range_rate_mps = 20.0;
  Drive(1.3, 10);
  EXPECT_EQ(errors_.Supposed(0).scale, 1.0);
}

TEST_F(RangeRateErrorsTest, AnOffsetThatIsTakenElsewhereIsForgottenAndAScaleIsNot) {
  Drive(1.0, 20, 2, 1.0);
  ASSERT_TRUE(errors_.Learned(0).is_offset());
  errors_.OnOffsetCorrected(0);
  EXPECT_TRUE(errors_.Whole(0).is_none());
  Drive(1.3, 20, 2);
  ASSERT_NEAR(errors_.Learned(0).scale, 1.3, 0.02);
  errors_.OnOffsetCorrected(0);
  EXPECT_NEAR(errors_.Whole(0).scale, 1.3, 0.02);
}

}  // namespace
}  // namespace dcloc
