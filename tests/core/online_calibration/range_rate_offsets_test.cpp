#include "core/online_calibration/range_rate_offsets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/core/options/option_fields_check.h"
#include "tests/core/radar/scan_fixture.h"

namespace dcloc {
namespace {

TEST(RangeRateOffsetOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<RangeRateOffsetOptions>();
}

EgoVelocity Driving(double speed_mps, double yaw_rate_radps = 0.0) {
  return {.linear_mps = {speed_mps, 0.0, 0.0},
          .angular_radps = {0.0, 0.0, yaw_rate_radps},
          .covariance = 1e-4 * Matrix6d::Identity()};
}

void Shift(double offset_mps, Scan& scan) {
  for (float& range_rate_mps : scan.range_rate_mps) {
    range_rate_mps += static_cast<float>(offset_mps);
  }
}

class RangeRateOffsetOfScanTest : public ::testing::Test {
 protected:
  std::optional<RangeRateOffsetReading> Read(const Scan& scan, const RadarModel& radar) {
    return RangeRateOffsetOfScan(scan, radar, 5, {}, workspace_);
  }

  RangeRateOffsetWorkspace workspace_;
};

TEST_F(RangeRateOffsetOfScanTest, TheOffsetIsFoundWhereverTheRadarLooksAndHoweverTheVehicleMoves) {
  for (const double yaw_rad : {0.0, 1.0, std::numbers::pi}) {
    const RadarModel radar = RadarAt("one", 2.0, 0.7, yaw_rad);
    for (const double offset_mps : {-1.0, 0.0, 0.4}) {
      for (const EgoVelocity& velocity : {Driving(12.0), Driving(5.0, 0.4), Driving(0.0)}) {
        Scan scan = StaticScan(radar, velocity, 60, 3, 1.0);
        Shift(offset_mps, scan);
        const auto reading = Read(scan, radar);
        ASSERT_TRUE(reading);
        EXPECT_LE(std::abs(reading->offset_mps.value - offset_mps),
                  4.0 * std::sqrt(reading->offset_mps.variance));
        EXPECT_LT(reading->offset_mps.variance, 0.2 * 0.2);
      }
    }
  }
}

TEST_F(RangeRateOffsetOfScanTest, MoversAreNoOffset) {
  const RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  Scan scan = StaticScan(radar, Driving(12.0), 60, 3, 1.0);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (std::abs(scan.azimuth_rad[i]) < 0.25F) scan.range_rate_mps[i] += 9.0F;
  }
  const auto reading = Read(scan, radar);
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->offset_mps.value, 0.0, 0.4);
}

TEST_F(RangeRateOffsetOfScanTest, ANarrowViewAFewTargetsOrAliasedRangeRatesTellNothing) {
  RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  Scan narrow = StaticScan(radar, Driving(12.0), 60, 3, 1.0);
  for (float& azimuth_rad : narrow.azimuth_rad) azimuth_rad *= 0.1F;
  EXPECT_FALSE(Read(narrow, radar));
  EXPECT_FALSE(Read(StaticScan(radar, Driving(12.0), 5, 3, 1.0), radar));
  EXPECT_FALSE(Read({}, radar));
  radar.unambiguous_range_rate_mps = 20.0;
  EXPECT_FALSE(Read(StaticScan(radar, Driving(12.0), 60, 3, 1.0), radar));
}

class RangeRateOffsetsTest : public ::testing::Test {
 protected:
  /// Whether the offset has changed. `fraction`: range rates of the sides are too large by this
  /// share of the speed, as by azimuths that err.
  bool Drive(double speed_mps, double offset_mps, int scans, double fraction = 0.0) {
    bool has_changed = false;
    for (int i = 0; i < scans; ++i) {
      stamp_ += std::chrono::milliseconds(200);
      Scan scan = StaticScan(radar_, Driving(speed_mps), 60, ++seed_, 1.0);
      Shift(offset_mps + fraction * speed_mps, scan);
      has_changed |= offsets_.OnScan(stamp_, 1, scan, radar_);
    }
    return has_changed;
  }

  RadarModel radar_ = RadarAt("left", 3.0, 0.8, 0.9);
  RangeRateOffsets offsets_{2, {}};
  Stamp stamp_{std::chrono::seconds(1)};
  unsigned seed_ = 0;
};

TEST_F(RangeRateOffsetsTest, AFewScansShowIt) {
  EXPECT_FALSE(Drive(10.0, 1.0, 3));
  EXPECT_EQ(offsets_.offset_mps(1), 0.0);
  EXPECT_TRUE(Drive(10.0, 1.0, 3));
  EXPECT_NEAR(offsets_.offset_mps(1), 1.0, 0.2);
  EXPECT_EQ(offsets_.offset_mps(0), 0.0);
}

TEST_F(RangeRateOffsetsTest, RightRangeRatesHaveNone) {
  for (const double speed_mps : {0.0, 8.0, 25.0, 3.0}) EXPECT_FALSE(Drive(speed_mps, 0.0, 50));
}

TEST_F(RangeRateOffsetsTest, WhatGrowsWithTheSpeedIsNone) {
  for (const double speed_mps : {15.0, 20.0, 5.0, 12.0}) {
    EXPECT_FALSE(Drive(speed_mps, 0.0, 30, 0.02));
  }
}

TEST_F(RangeRateOffsetsTest, ASmallOneShowsAsTheVehicleSlows) {
  EXPECT_FALSE(Drive(15.0, 0.3, 40));
  EXPECT_TRUE(Drive(2.0, 0.3, 20));
  EXPECT_NEAR(offsets_.offset_mps(1), 0.3, 0.1);
}

TEST_F(RangeRateOffsetsTest, AnotherOneIsFoundAndSoIsItsEnd) {
  Drive(10.0, 1.0, 20);
  EXPECT_TRUE(Drive(10.0, -1.0, 10));
  EXPECT_NEAR(offsets_.offset_mps(1), -1.0, 0.2);
  EXPECT_TRUE(Drive(10.0, 0.0, 10));
  EXPECT_EQ(offsets_.offset_mps(1), 0.0);
}

}  // namespace
}  // namespace dcloc
