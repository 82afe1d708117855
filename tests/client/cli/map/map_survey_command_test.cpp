#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "tests/client/cli/fixtures/simulated.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

class MapSurveyCommandTest : public Simulated {};

TEST_F(MapSurveyCommandTest, SurveysADriveWithoutItsPoses) {
  const Result made = Dcloc("map survey " + Dataset() +
                            " --drive map,live-0 --compare-truth --json --trajectory-out " +
                            File("s.tum") + " --out " + File("s.dclm"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto json = nlohmann::json::parse(made.out);
  EXPECT_TRUE(json["drives"][0]["is_in_map"]);
  EXPECT_TRUE(json["drives"][1]["is_in_map"]) << json["drives"][1]["reason"];
  EXPECT_LT(json["truth"]["rmse_m"], 0.5);
  EXPECT_EQ(json["truth"]["wrong_loop_count"], 0);
  EXPECT_EQ(Dcloc("map inspect " + File("s.dclm")).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(File("s.tum")));
  for (const char* const drive : {"map", "live-0"}) {
    const std::string tum = ReadText(File(absl::StrCat("s-", drive, ".tum")));
    const auto pose_count = std::count(tum.begin(), tum.end(), '\n');
    EXPECT_GT(pose_count, 50) << drive;
    EXPECT_EQ(std::count(tum.begin(), tum.end(), ' '), 7 * pose_count) << drive;
  }
}

TEST_F(MapSurveyCommandTest, SurveyWritesNothingWhenNothingMoved) {
  const Result none =
      Dcloc("map survey " + Dataset() + " --drive map --to-s 0.3 --out " + File("none.dclm"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("map: it moved"));
  EXPECT_FALSE(std::filesystem::exists(File("none.dclm")));
}

TEST_F(MapSurveyCommandTest, ACheckpointGoesOnceTheMapIsThere) {
  const std::string command = "map survey " + Dataset() + " --drive map --out " + File("k.dclm") +
                              " --checkpoint " + File("k.checkpoint");
  std::ofstream(File("k.checkpoint")) << "no checkpoint";
  const Result refused = Dcloc(command);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr(File("k.checkpoint") + ": no checkpoint of a survey"));
  EXPECT_FALSE(std::filesystem::exists(File("k.dclm")));
  EXPECT_TRUE(std::filesystem::remove(File("k.checkpoint")));
  const Result made = Dcloc(command);
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_TRUE(std::filesystem::exists(File("k.dclm")));
  EXPECT_FALSE(std::filesystem::exists(File("k.checkpoint")));
}

TEST_F(MapSurveyCommandTest, SaysWhatIsWrongWithTheRadars) {
  const std::string command = "map survey " + Dataset() + " --drive map --json --out ";
  const Result made = Dcloc(command + File("c.dclm") + " --rig-out " + File("rig.json"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto json = nlohmann::json::parse(made.out);
  ASSERT_FALSE(json["radars"].empty());
  const auto rig = nlohmann::json::parse(ReadText(File("rig.json")));
  EXPECT_EQ(rig["radars"].size(), json["radars"].size());
  EXPECT_EQ(rig["radars"][0]["id"], json["radars"][0]["id"]);
  const Result again =
      Dcloc(command + File("d.dclm") + " --no-calibration --rig " + File("rig.json"));
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(nlohmann::json::parse(again.out)["radars"].empty());
}

TEST_F(MapSurveyCommandTest, ARigIsNotWrittenWithoutACalibration) {
  const Result refused = Dcloc("map survey " + Dataset() + " --drive map --no-calibration --out " +
                               File("e.dclm") + " --rig-out " + File("none.json"));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--no-calibration excludes --rig-out"));
  EXPECT_FALSE(std::filesystem::exists(File("none.json")));
}

}  // namespace
}  // namespace dcloc
