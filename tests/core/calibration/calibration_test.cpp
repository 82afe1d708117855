#include "core/calibration/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace dcloc {
namespace {

TEST(CalibratedParameterTest, IsDeterminedWhenTheDataHalveItsDeviation) {
  EXPECT_TRUE((CalibratedParameter{.sigma = 0.4, .prior_sigma = 1.0}.determined()));
  EXPECT_FALSE((CalibratedParameter{.sigma = 0.6, .prior_sigma = 1.0}.determined()));
}

TEST(CalibratedParameterTest, IsSignificantWhenItsIntervalLeavesOutZero) {
  EXPECT_TRUE(
      (CalibratedParameter{.correction = -0.21, .sigma = 0.1, .prior_sigma = 1.0}.significant()));
  EXPECT_FALSE(
      (CalibratedParameter{.correction = 0.19, .sigma = 0.1, .prior_sigma = 1.0}.significant()));
  EXPECT_FALSE(
      (CalibratedParameter{.correction = 5.0, .sigma = 0.9, .prior_sigma = 1.0}.significant()));
}

Calibration TwoParametersOfOneRadar(double correlation) {
  Calibration calibration;
  RadarCalibration radar{.described = {.id = "front"}, .parameters = {}};
  for (CalibratedParameter& value : radar.parameters) value = {.sigma = 0.1, .prior_sigma = 1.0};
  calibration.radars = {radar};
  calibration.covariance =
      0.01 * Eigen::MatrixXd::Identity(kCalibrationParameters, kCalibrationParameters);
  calibration.covariance(0, 1) = calibration.covariance(1, 0) = 0.01 * correlation;
  return calibration;
}

TEST(CalibrationTest, NamesWhatTheDataCannotTellApart) {
  const auto confusions = TwoParametersOfOneRadar(-0.95).Confusions();
  ASSERT_EQ(confusions.size(), 1U);
  EXPECT_EQ(confusions[0].radar, "front");
  EXPECT_EQ(confusions[0].parameter, CalibrationParameter::kBeta);
  EXPECT_EQ(confusions[0].other_parameter, CalibrationParameter::kTimeOffset);
  EXPECT_DOUBLE_EQ(confusions[0].correlation, -0.95);
  EXPECT_THAT(TwoParametersOfOneRadar(0.85).Confusions(), ::testing::IsEmpty());
}

TEST(CalibrationTest, ConfusesNothingWithWhatWasLeftAlone) {
  Calibration calibration = TwoParametersOfOneRadar(0.0);
  calibration.covariance.col(0).setZero();
  calibration.covariance.row(0).setZero();
  EXPECT_THAT(calibration.Confusions(), ::testing::IsEmpty());
}

TEST(CorrectedTest, TurnsTheMountAboutTheVehiclesAxis) {
  RadarModel radar{.id = "left"};
  radar.T_vehicle_radar = Embed(Pose2{.translation_m = {3.0, 1.0}, .yaw_rad = 1.0});
  const RadarModel corrected = Corrected(radar, CalibrationParameter::kMountYaw, 0.02);
  EXPECT_NEAR(Yaw(corrected.T_vehicle_radar.rotation), 1.02, 1e-12);
  EXPECT_EQ(corrected.T_vehicle_radar.translation_m, radar.T_vehicle_radar.translation_m);
}

TEST(CorrectedTest, AddsToTheRest) {
  const RadarModel radar{.id = "left", .beta_s = 0.04, .range_bias_m = 0.1, .time_offset_s = 0.01};
  EXPECT_DOUBLE_EQ(Corrected(radar, CalibrationParameter::kBeta, -0.01).beta_s, 0.03);
  EXPECT_DOUBLE_EQ(Corrected(radar, CalibrationParameter::kRangeBias, 0.2).range_bias_m, 0.3);
  EXPECT_DOUBLE_EQ(Corrected(radar, CalibrationParameter::kTimeOffset, 0.02).time_offset_s, 0.03);
}

}  // namespace
}  // namespace dcloc
