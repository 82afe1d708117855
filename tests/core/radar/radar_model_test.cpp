#include "core/radar/radar_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dcloc {
namespace {

using ::testing::HasSubstr;

TEST(RigTest, FindsByIdAndRefusesTwins) {
  Rig rig{.radars = {{.id = "front"}, {.id = "rear", .has_elevation = true}}};
  EXPECT_TRUE(Validate(rig).ok());
  EXPECT_EQ(rig.Find("rear"), &rig.radars[1]);
  EXPECT_EQ(rig.Find("side"), nullptr);
  EXPECT_FALSE(rig.MeasuresElevation());
  rig.radars[1].id = "front";
  EXPECT_THAT(Validate(rig).message(), HasSubstr("two radars with the id 'front'"));
  EXPECT_FALSE(Validate(Rig{}).ok());
}

TEST(RadarModelTest, ErrorsNameRadarFieldValueAndBound) {
  RadarModel radar{.id = "front"};
  radar.azimuth_sigma_rad = 0.0;
  EXPECT_EQ(Validate(radar).message(),
            "radar 'front': azimuth_sigma_rad is 0; it must lie in [0.0001, 1]");
  radar = {.id = "front", .beta_s = 3.0};
  EXPECT_THAT(Validate(radar).message(), HasSubstr("beta_s is 3"));
  radar = {.id = "front", .range_bias_m = -11.0};
  EXPECT_THAT(Validate(radar).message(), HasSubstr("range_bias_m is -11"));
  radar = {.id = "front", .time_offset_s = 1.5};
  EXPECT_THAT(Validate(radar).message(), HasSubstr("time_offset_s is 1.5"));
  radar = {.id = "front", .beta_sigma_s = -0.1};
  EXPECT_THAT(Validate(radar).message(), HasSubstr("beta_sigma_s is -0.1"));
  radar = {.id = "front", .range_bias_sigma_m = 11.0};
  EXPECT_THAT(Validate(radar).message(), HasSubstr("range_bias_sigma_m is 11"));
  radar = {.id = "front", .time_offset_sigma_s = 1.5};
  EXPECT_THAT(Validate(radar).message(), HasSubstr("time_offset_sigma_s is 1.5"));
  radar = {.id = "front", .mount_yaw_sigma_rad = std::nan("")};
  EXPECT_THAT(Validate(radar).message(), HasSubstr("mount_yaw_sigma_rad is nan"));
  radar = {.id = "front"};
  radar.T_vehicle_radar.translation_m.y() = std::nan("");
  EXPECT_THAT(Validate(radar).message(), HasSubstr("T_vehicle_radar.translation_m.y is nan"));
  radar = {.id = ""};
  EXPECT_FALSE(Validate(radar).ok());
}

TEST(RadarModelTest, BetaOfAChirp) {
  // 76.5 GHz swept by 1.9125 THz/s: the paper's 0.04 s.
  EXPECT_NEAR(BetaFromChirp(76.5e9, 1.9125e12), 0.04, 1e-12);
}

}  // namespace
}  // namespace dcloc
