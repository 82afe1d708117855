#include "core/calibration/calibrator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/core/localizer/synthetic_world.h"
#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

constexpr double kSigmas99 = 2.58;
// Half as many scans as usual are enough, and a fourth of their pairs: sanitizers take their time.
constexpr int kPeriod_ms = 154;

Rig ThreeRadars(double beta_s) {
  Rig rig = FrontRadar(beta_s);
  for (const double side : {1.0, -1.0}) {
    RadarModel radar = rig.radars[0];
    radar.id = side > 0 ? "left" : "right";
    radar.T_vehicle_radar = Embed(Pose2{.translation_m = {3.0, side}, .yaw_rad = side * 1.3});
    rig.radars.push_back(radar);
  }
  return rig;
}

// Two passes of the bend, as `truth` measures them with the rig `described`.
Calibrator TwoPasses(const Rig& truth, const Rig& described, double range_bias_m = 0.0,
                     const CalibratorOptions& options = {}) {
  const SyntheticWorld world;
  auto calibrator = Calibrator::Create(described, options);
  EXPECT_TRUE(calibrator.ok()) << calibrator.status();
  for (const double speed_mps : {8.0, 20.0}) {
    for (TrueScan& seen : DriveRoad(world, truth, speed_mps, 7, kPeriod_ms)) {
      for (float& range_m : seen.scan.range_m) range_m += static_cast<float>(range_bias_m);
      const absl::Status status =
          calibrator->Add("bend", seen.scan, seen.T_map_vehicle, *seen.scan.ego_velocity);
      EXPECT_TRUE(status.ok()) << status;
    }
  }
  return *std::move(calibrator);
}

void ExpectWithin(const CalibratedParameter& found, double truth) {
  EXPECT_TRUE(found.determined()) << found.sigma;
  EXPECT_NEAR(found.correction, truth, kSigmas99 * found.sigma);
}

class BetaTest : public ::testing::TestWithParam<double> {};

TEST_P(BetaTest, IsFoundWithinItsInterval) {
  const auto calibration = TwoPasses(ThreeRadars(GetParam()), ThreeRadars(0.0)).Estimate();
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  for (const RadarCalibration& radar : calibration->radars) {
    SCOPED_TRACE(radar.described.id);
    const CalibratedParameter& beta = radar.of(CalibrationParameter::kBeta);
    ExpectWithin(beta, GetParam());
    EXPECT_LT(beta.sigma, 0.006);
  }
}

INSTANTIATE_TEST_SUITE_P(Betas, BetaTest, ::testing::Values(-0.02, 0.0, 0.02, 0.04));

TEST(CalibratorTest, FindsATurnedMount) {
  constexpr double kTurn_rad = 0.012;
  Rig truth = ThreeRadars(0.0);
  truth.radars[1] = Corrected(truth.radars[1], CalibrationParameter::kMountYaw, kTurn_rad);
  const auto calibration = TwoPasses(truth, ThreeRadars(0.0)).Estimate();
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  ExpectWithin(calibration->radars[0].of(CalibrationParameter::kMountYaw), 0.0);
  ExpectWithin(calibration->radars[1].of(CalibrationParameter::kMountYaw), kTurn_rad);
  ExpectWithin(calibration->radars[2].of(CalibrationParameter::kMountYaw), 0.0);
  EXPECT_TRUE(calibration->radars[1].of(CalibrationParameter::kMountYaw).significant());
}

TEST(CalibratorTest, FindsARangeBias) {
  const auto calibration = TwoPasses(ThreeRadars(0.0), ThreeRadars(0.0), 0.25).Estimate();
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  for (const RadarCalibration& radar : calibration->radars) {
    ExpectWithin(radar.of(CalibrationParameter::kRangeBias), 0.25);
  }
}

// What is right already stays as described, whatever noise says.
TEST(CalibratorTest, AppliesWhatIsWrongAndLeavesTheRest) {
  Rig truth = ThreeRadars(0.0);
  truth.radars[1] = Corrected(truth.radars[1], CalibrationParameter::kMountYaw, 0.012);
  const auto calibration = TwoPasses(truth, ThreeRadars(0.0)).Estimate();
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  for (const RadarCalibration& radar : calibration->radars) {
    SCOPED_TRACE(radar.described.id);
    const CalibratedParameter& beta = radar.of(CalibrationParameter::kBeta);
    EXPECT_EQ(beta.applied, 0.0);
    EXPECT_GE(beta.remaining_sigma, std::abs(beta.correction));
    EXPECT_LE(beta.remaining_sigma, beta.prior_sigma);
  }
  EXPECT_NEAR(calibration->radars[1].of(CalibrationParameter::kMountYaw).applied, 0.012, 0.004);
}

TEST(CalibratorTest, LeavesAloneWhatIsKnown) {
  CalibratorOptions options;
  options.prior_sigma.at(static_cast<std::size_t>(CalibrationParameter::kRangeBias)) = 0.0;
  const auto calibration = TwoPasses(ThreeRadars(0.0), ThreeRadars(0.0), 0.25, options).Estimate();
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  for (const RadarCalibration& radar : calibration->radars) {
    const CalibratedParameter& bias = radar.of(CalibrationParameter::kRangeBias);
    EXPECT_EQ(bias.correction, 0.0);
    EXPECT_EQ(bias.sigma, 0.0);
    EXPECT_EQ(bias.remaining_sigma, 0.0);
  }
}

// Driving straight at one speed with one radar, beta moves everything as a time offset does.
TEST(CalibratorTest, SaysWhatOneStraightPassCannotDetermine) {
  const SyntheticWorld world;
  Rig rig = FrontRadar();
  auto calibrator = Calibrator::Create(rig);
  ASSERT_TRUE(calibrator.ok());
  for (const TrueScan& seen : DriveRoad(world, rig, 15.0, 3)) {
    ASSERT_TRUE(
        calibrator->Add("bend", seen.scan, seen.T_map_vehicle, *seen.scan.ego_velocity).ok());
  }
  const auto calibration = calibrator->Estimate();
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_FALSE(calibration->radars[0].of(CalibrationParameter::kTimeOffset).determined());
}

TEST(CalibratorTest, GivesTheSameTwice) {
  const Calibrator calibrator = TwoPasses(ThreeRadars(0.02), ThreeRadars(0.0));
  EXPECT_EQ(calibrator.Estimate()->covariance, calibrator.Estimate()->covariance);
}

TEST(CalibratorTest, NamesWhatIsWrongWithAScan) {
  const Rig rig = FrontRadar();
  auto calibrator = Calibrator::Create(rig);
  ASSERT_TRUE(calibrator.ok());
  Scan scan{.stamp = Stamp(std::chrono::seconds(1)), .radar_id = "roof"};
  absl::Status status = calibrator->Add("bend", scan, {}, {});
  EXPECT_THAT(std::string(status.message()), HasSubstr("roof"));
  scan.radar_id = "front";
  Pose3 nowhere;
  nowhere.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  status = calibrator->Add("bend", scan, nowhere, {});
  EXPECT_THAT(std::string(status.message()), HasSubstr("translation_m"));
}

TEST(CalibratorTest, SaysWhenThereIsNothingToGoBy) {
  const auto calibrator = Calibrator::Create(FrontRadar());
  ASSERT_TRUE(calibrator.ok());
  const auto calibration = calibrator->Estimate();
  EXPECT_EQ(calibration.status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(CalibratorOptionsTest, EachFieldIsBounded) { ExpectEachFieldIsBounded<CalibratorOptions>(); }

TEST(CalibratorTest, RefusesOptionsThatMakeNoSense) {
  const auto message = [](const CalibratorOptions& options) {
    return std::string(Calibrator::Create(FrontRadar(), options).status().message());
  };
  EXPECT_THAT(message({.prior_sigma = {-1.0, 1.0, 1.0, 1.0, 1.0, 1.0}}), HasSubstr("prior_sigma"));
  EXPECT_THAT(message({.scatterer_sigmas_m = {}}), HasSubstr("scatterer_sigmas_m"));
  EXPECT_THAT(message({.static_points = {.static_gate_mps = std::nan("")}}),
              HasSubstr("static_points.static_gate_mps"));
  EXPECT_THAT(message({.floor_sigma = {0.0, 0.0, std::nan(""), 0.0, 0.0, 0.0}}),
              HasSubstr("floor_sigma"));
  EXPECT_THAT(message({.iterations_per_sigma = 0}), HasSubstr("iterations_per_sigma"));
  EXPECT_THAT(message({.max_pair_distance_m = std::nan("")}), HasSubstr("max_pair_distance_m"));
}

}  // namespace
}  // namespace dcloc
