#include "server/convert/calibration.h"

#include <gtest/gtest.h>

namespace dcloc::server {
namespace {

TEST(ConvertCalibrationTest, EachValueGetsItsOwnField) {
  RadarCalibration radar;
  radar.described.id = "front@live-0";
  radar.described.beta_s = 0.04;
  for (int i = 0; i < kCalibrationParameters; ++i) {
    radar.parameters.at(static_cast<std::size_t>(i)) = {
        .correction = 1.0 + i, .sigma = 0.1 + i, .prior_sigma = 0.2 + i, .applied = 0.3 + i};
  }
  v1::SurveyedRadar message;
  convert::ToProto(radar, &message);
  EXPECT_EQ(message.radar_id(), "front@live-0");
  EXPECT_EQ(message.described_beta_s(), 0.04);
  EXPECT_EQ(message.beta_s().correction(), 1.0);
  EXPECT_EQ(message.beta_s().sigma(), 0.1);
  EXPECT_EQ(message.beta_s().prior_sigma(), 0.2);
  EXPECT_EQ(message.beta_s().applied(), 0.3);
  EXPECT_EQ(message.time_offset_s().correction(), 2.0);
  EXPECT_EQ(message.range_bias_m().correction(), 3.0);
  EXPECT_EQ(message.mount_yaw_rad().correction(), 4.0);
}

}  // namespace
}  // namespace dcloc::server
