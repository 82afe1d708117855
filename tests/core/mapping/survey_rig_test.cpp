#include "core/mapping/survey_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dcloc {
namespace {

using ::testing::UnorderedElementsAre;

Rig Of(const std::vector<std::string>& ids, double range_bias_m = 0.0) {
  Rig rig;
  for (const std::string& id : ids) {
    rig.radars.push_back({.id = id, .range_bias_m = range_bias_m});
  }
  return rig;
}

/// Of one radar: a range bias, known to 0.02 m; of all else nothing is known.
Calibration RangeBias(const RadarModel& described, double correction_m) {
  RadarCalibration radar{.described = described, .parameters = {}};
  for (CalibratedParameter& parameter : radar.parameters) {
    parameter = {.sigma = 1.0, .prior_sigma = 1.0};
  }
  constexpr auto kKind = static_cast<std::size_t>(CalibrationParameter::kRangeBias);
  radar.parameters.at(kKind) = {.correction = correction_m, .sigma = 0.02, .prior_sigma = 0.3};
  Calibration calibration;
  calibration.radars.push_back(std::move(radar));
  calibration.covariance =
      Eigen::MatrixXd::Identity(kCalibrationParameters, kCalibrationParameters);
  calibration.covariance(kKind, kKind) = 0.02 * 0.02;
  return calibration;
}

TEST(SurveyRigTest, DrivesThatShareARadarAreOfOneVehicle) {
  SurveyRig rig;
  rig.Add("a", Of({"front", "left"}));
  rig.Add("b", Of({"front", "left"}, 0.5));
  rig.Add("c", Of({"front", "rear"}));
  rig.Add("c", Of({"front", "rear"}));
  const std::vector<SurveyVehicle> vehicles = rig.Vehicles();
  ASSERT_EQ(vehicles.size(), 2U);
  EXPECT_EQ(vehicles[0].rig.radars[0].id, "front@b");
  EXPECT_THAT(vehicles[0].drives, UnorderedElementsAre("b"));
  EXPECT_EQ(vehicles[1].rig.radars.size(), 3U);
  EXPECT_TRUE(vehicles[1].Drove("a"));
  EXPECT_TRUE(vehicles[1].Drove("c"));
}

TEST(SurveyRigTest, ARadarIsTakenAsItIsKnown) {
  SurveyRig rig;
  rig.Add("a", Of({"front"}));
  rig.Add("b", Of({"front"}, 0.5));
  EXPECT_TRUE(rig.calibrations().empty());
  EXPECT_TRUE(rig.Learn(RangeBias(*rig.Known().Find("front@b"), 0.1)));
  const Rig known = rig.Of("b", Of({"front"}, 0.5));
  EXPECT_EQ(known.radars[0].id, "front");
  EXPECT_NEAR(known.radars[0].range_bias_m, 0.6, 1e-12);
  EXPECT_EQ(rig.Of("a", Of({"front"})).radars[0].range_bias_m, 0.0);
}

TEST(SurveyRigTest, WhatIsFoundAgainIsAddedToWhatWasFound) {
  SurveyRig rig;
  rig.Add("a", Of({"front"}));
  EXPECT_TRUE(rig.Learn(RangeBias(rig.Known().radars[0], 0.1)));
  EXPECT_TRUE(rig.Learn(RangeBias(rig.Known().radars[0], 0.05)));
  EXPECT_FALSE(rig.Learn(RangeBias(rig.Known().radars[0], 0.03))) << "within 95 %";
  EXPECT_NEAR(rig.Known().radars[0].range_bias_m, 0.15, 1e-12);
  const CalibratedParameter& total = rig.calibrations()[0].of(CalibrationParameter::kRangeBias);
  EXPECT_NEAR(total.applied, 0.15, 1e-12);
  EXPECT_EQ(rig.calibrations()[0].described.range_bias_m, 0.0);
}

TEST(SurveyRigTest, ClocksTogetherAreKnownAsBefore) {
  SurveyRig rig;
  Rig described = Of({"front"});
  described.radars[0].time_offset_sigma_s = 0.05;
  rig.Add("a", described);
  EXPECT_TRUE(rig.Learn(RangeBias(described.radars[0], 0.1)));
  EXPECT_EQ(rig.Known().radars[0].time_offset_sigma_s, 0.05);
  EXPECT_EQ(rig.Known().radars[0].range_bias_sigma_m, 0.02);
}

TEST(SurveyRigTest, WhatTurnsOutToBeNothingIsTakenBack) {
  SurveyRig rig;
  rig.Add("a", Of({"front"}));
  EXPECT_TRUE(rig.Learn(RangeBias(rig.Known().radars[0], 0.1)));
  EXPECT_TRUE(rig.Learn(RangeBias(rig.Known().radars[0], -0.08)));
  EXPECT_EQ(rig.Known().radars[0].range_bias_m, 0.0);
}

}  // namespace
}  // namespace dcloc
