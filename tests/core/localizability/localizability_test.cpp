#include "core/localizability/localizability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/localizability/row_map.h"
#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

/// Of a vehicle whose radar is calibrated: along a straight row nothing tells a late clock.
LocalizabilityOptions Calibrated() {
  LocalizabilityOptions options;
  RadarModel& radar = options.vehicle.rig.radars.front();
  radar.time_offset_sigma_s = 0.001;
  radar.mount_yaw_sigma_rad = 0.001;
  radar.range_bias_sigma_m = 0.01;
  radar.beta_sigma_s = 0.0005;
  return options;
}

std::vector<KeyframeLocalizability> Compute(const std::shared_ptr<const RadarMap>& map) {
  const auto result = ComputeLocalizability(map, Calibrated(), [](double) { return true; });
  EXPECT_TRUE(result.ok()) << result.status();
  return result.value_or(std::vector<KeyframeLocalizability>());
}

TEST(LocalizabilityTest, OptionsAreChecked) {
  ExpectEachFieldIsBounded<LocalizabilityOptions>();
  ExpectedVehicle vehicle = LocalizabilityOptions::DefaultVehicle();
  vehicle.speed_mps = -1.0;
  EXPECT_THAT(std::string(Validate(vehicle).message()), HasSubstr("speed_mps is -1"));
}

TEST(LocalizabilityTest, ARowOfPostsTellsWhereAVehicleIs) {
  const auto keyframes = Compute(RowMap(40, ScatteredPosts(0.0, 480.0)));
  ASSERT_EQ(keyframes.size(), 40U);
  for (std::size_t i = 10; i < 35; ++i) {
    EXPECT_TRUE(keyframes[i].is_known) << i;
    EXPECT_FALSE(keyframes[i].is_tunnel) << i;
    EXPECT_LT(keyframes[i].along_sigma_m, 0.1) << i;
    EXPECT_LT(keyframes[i].across_sigma_m, 0.1) << i;
    EXPECT_GT(keyframes[i].tracking_share, 0.9) << i;
  }
}

TEST(LocalizabilityTest, WhereNothingStandsTheVehicleKnowsLess) {
  std::vector<TestLandmark> landmarks = ScatteredPosts(0.0, 200.0);
  for (const TestLandmark& post : ScatteredPosts(420.0, 600.0)) landmarks.push_back(post);
  const auto keyframes = Compute(RowMap(60, landmarks));
  EXPECT_GT(keyframes[33].across_sigma_m, 5.0 * keyframes[12].across_sigma_m);
  EXPECT_LT(keyframes[50].across_sigma_m, 1.5 * keyframes[12].across_sigma_m) << "it recovers";
  EXPECT_LT(keyframes[1].across_sigma_m, 2.0 * keyframes[12].across_sigma_m) << "from the start";
  EXPECT_LT(keyframes[33].tracking_share, keyframes[12].tracking_share);
}

TEST(LocalizabilityTest, TheSameMapGivesTheSame) {
  const auto map = RowMap(20, ScatteredPosts(0.0, 280.0));
  const auto once = Compute(map);
  const auto again = Compute(map);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].along_sigma_m, again[i].along_sigma_m);
  }
}

TEST(LocalizabilityTest, AMapOfOneKeyframeSaysNothing) {
  const auto keyframes = Compute(RowMap(1, ScatteredPosts(0.0, 10.0)));
  ASSERT_EQ(keyframes.size(), 1U);
  EXPECT_FALSE(keyframes[0].is_known);
  EXPECT_FALSE(AccuracyOf(keyframes[0]).sigmas.has_value());
}

TEST(LocalizabilityTest, CanBeEndedAndNamesWhatIsWrong) {
  const auto map = RowMap(20, ScatteredPosts(0.0, 280.0));
  const auto ended = ComputeLocalizability(map, {}, [](double) { return false; });
  EXPECT_EQ(ended.status().code(), absl::StatusCode::kCancelled);
  LocalizabilityOptions options;
  options.vehicle.rig.radars.clear();
  const auto none = ComputeLocalizability(map, options, [](double) { return true; });
  EXPECT_EQ(none.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(none.status().message()), HasSubstr("rig"));
}

}  // namespace
}  // namespace dcloc
