#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/cli/fixtures/simulated.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

class CalibrateCommandTest : public Simulated {};

TEST_F(CalibrateCommandTest, CalibratesARigThatAMapIsBuiltWith) {
  const Result result = Dcloc("calibrate " + Dataset() + " --drive map,live-0 --beta-s 0 --json" +
                              " --out " + File("rig.json"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto beta = nlohmann::json::parse(result.out)["radars"][0]["beta_s"];
  EXPECT_NEAR(beta["correction"].get<double>(), 0.04, 0.01);  // what the simulator measures with
  EXPECT_LT(beta["interval_95"][0].get<double>(), 0.04);
  EXPECT_GT(beta["interval_95"][1].get<double>(), 0.04);
  const auto rig = nlohmann::json::parse(ReadText(File("rig.json")));
  EXPECT_EQ(rig["radars"][0]["beta_s"], beta["correction"]);
  EXPECT_EQ(rig["radars"][0]["beta_sigma_s"], beta["sigma"]);
  const Result built = Dcloc("map build " + Dataset() + " --drive map --rig " + File("rig.json") +
                             " --out " + File("c.dclm"));
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_THAT(built.out, HasSubstr("(beta 0.0"));
}

TEST_F(CalibrateCommandTest, KeepsWhatIsKnownForSure) {
  const Result result =
      Dcloc("calibrate " + Dataset() + " --drive map --keep time,range,yaw --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto radar = nlohmann::json::parse(result.out)["radars"][0];
  for (const char* kept : {"time_offset_s", "range_bias_m", "mount_yaw_rad"}) {
    EXPECT_NEAR(radar[kept]["correction"].get<double>(), 0.0, 1e-5) << kept;
    EXPECT_FALSE(radar[kept]["determined"].get<bool>()) << kept;
  }
}

}  // namespace
}  // namespace dcloc
