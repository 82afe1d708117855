#include "client/datasets/rig_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

class RigFileTest : public ::testing::Test {
 protected:
  absl::Status Apply(const std::string& text) {
    const auto path = folder_.path() / "rig.json";
    std::ofstream(path) << text;
    return ApplyRigFile(path, rig_);
  }
  std::string Message(const std::string& text) { return std::string(Apply(text).message()); }

  const RadarModel& radar() const { return rig_.radars[0]; }

 private:
  TempFolder folder_;
  Rig rig_ = {
      .radars = {{.id = "front",
                  .T_vehicle_radar = Embed(Pose2{.translation_m = {3.0, 0.0}, .yaw_rad = 0.1})}}};
};

TEST_F(RigFileTest, TakesOverWhatItSays) {
  ASSERT_TRUE(Apply(R"({"radars": [{"id": "front", "beta_s": 0.04, "range_bias_m": -0.2,
                        "time_offset_s": 0.03, "mount_yaw_correction_rad": 0.02,
                        "beta_sigma_s": 0.001, "range_bias_sigma_m": 0.02,
                        "time_offset_sigma_s": 0.004, "mount_yaw_sigma_rad": 0.003}]})")
                  .ok());
  EXPECT_DOUBLE_EQ(radar().beta_s, 0.04);
  EXPECT_DOUBLE_EQ(radar().range_bias_m, -0.2);
  EXPECT_DOUBLE_EQ(radar().time_offset_s, 0.03);
  EXPECT_DOUBLE_EQ(radar().beta_sigma_s, 0.001);
  EXPECT_DOUBLE_EQ(radar().range_bias_sigma_m, 0.02);
  EXPECT_DOUBLE_EQ(radar().time_offset_sigma_s, 0.004);
  EXPECT_DOUBLE_EQ(radar().mount_yaw_sigma_rad, 0.003);
  EXPECT_NEAR(Yaw(radar().T_vehicle_radar.rotation), 0.12, 1e-12);
  EXPECT_DOUBLE_EQ(radar().range_sigma_m, RadarModel().range_sigma_m);
}

TEST_F(RigFileTest, NamesTheFileTheRadarAndTheFault) {
  EXPECT_THAT(Message(R"({"radars": []})"), AllOf(HasSubstr("rig.json"), HasSubstr("front")));
  EXPECT_THAT(Message(R"({"radars": [{"id": "front", "beta": 0.04}]})"), HasSubstr("\"beta\""));
  EXPECT_THAT(Message(R"({"radars": [{"id": "front", "beta_s": "high"}]})"),
              HasSubstr("must be a number"));
  EXPECT_THAT(Message(R"({"radars": [{"id": "front", "time_offset_s": 7}]})"),
              AllOf(HasSubstr("front"), HasSubstr("time_offset_s"), HasSubstr("7")));
  EXPECT_THAT(Message("{"), HasSubstr("rig.json"));
}

}  // namespace
}  // namespace dcloc
