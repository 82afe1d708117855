#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/cli/fixtures/server_commands.h"

// `dcloc map` with a server.
namespace dcloc {
namespace {

using ::testing::HasSubstr;

using MapCommandsTest = ServerCommands;

TEST_F(MapCommandsTest, MapsAreListedActivatedAndDeleted) {
  Upload();
  ASSERT_EQ(Dcloc("map build " + Data() + " --name second --out " + File("second")).exit_code, 0);
  ASSERT_EQ(Dcloc(At("map upload") + "--map town " + File("second")).exit_code, 0);
  auto maps = nlohmann::json::parse(Dcloc(At("map list") + "--json").out);
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0]["name"], "town");
  EXPECT_EQ(maps[0]["active_version"], 1);
  EXPECT_EQ(maps[0]["version_count"], 2);
  EXPECT_EQ(Dcloc(At("map activate") + "--map town --version 2").exit_code, 0);
  const auto versions = nlohmann::json::parse(Dcloc(At("map list") + "--map town --json").out);
  EXPECT_EQ(versions[0]["version"], 2);
  EXPECT_EQ(versions[0]["active"], true);
  EXPECT_GT(versions[0]["point_count"], 100);

  Result result = Dcloc(At("map delete") + "--map town --version 2");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("active"));
  EXPECT_EQ(Dcloc(At("map delete") + "--map town").exit_code, 2);
  EXPECT_EQ(Dcloc(At("map delete") + "--map town --version 2 --drain").exit_code, 1);
  result = Dcloc(At("map delete") + "--map town --version 1 --drain --json");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["version"], 1);
  EXPECT_EQ(Dcloc(At("map delete") + "--map town --all-versions").exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(Dcloc(At("map list") + "--json").out).size(), 0U);
}

TEST_F(MapCommandsTest, LabelsAreSetAndTakenBack) {
  Upload();
  ASSERT_EQ(Dcloc("map build " + Data() + " --name second --out " + File("second")).exit_code, 0);
  ASSERT_EQ(Dcloc(At("map upload") + "--map town " + File("second")).exit_code, 0);
  Result result = Dcloc(At("map rollback") + "--map town");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("active before"));
  result = Dcloc(At("map canary") + "--map town --version 2 --share 0.25");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("25 % of the vehicles get version 2"));
  EXPECT_EQ(Dcloc(At("map canary") + "--map town --version 2").exit_code, 2);
  EXPECT_EQ(Dcloc(At("map canary") + "--map town --version 2 --none").exit_code, 2);
  EXPECT_EQ(Dcloc(At("map canary") + "--map town --version 2 --share 2").exit_code, 2);
  auto map = nlohmann::json::parse(Dcloc(At("map canary") + "--map town --none --json").out);
  EXPECT_EQ(map["canary_version"], 0);
  map = nlohmann::json::parse(Dcloc(At("map activate") + "--map town --version 2 --json").out);
  EXPECT_EQ(map["active_version"], 2);
  EXPECT_EQ(map["previous_version"], 1);
  map = nlohmann::json::parse(Dcloc(At("map rollback") + "--map town --move-sessions --json").out);
  EXPECT_EQ(map["active_version"], 1);
  EXPECT_EQ(map["moved_session_count"], 0);
}

TEST_F(MapCommandsTest, MapsAreFoundByPlaceAndDownloaded) {
  Upload();
  const std::string place = " --map town --x-m 0 --y-m 0 ";
  Result result = Dcloc(At("map coverage") + place + "--radius-m 10000 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto coverages = nlohmann::json::parse(result.out);
  ASSERT_EQ(coverages.size(), 1U);
  EXPECT_EQ(coverages[0]["map"], "town");
  EXPECT_EQ(coverages[0]["version"], 1);
  EXPECT_THAT(Dcloc(At("map coverage") + place).out, HasSubstr("distance [m]"));
  result = Dcloc(At("map coverage") + "--latitude-deg 91 --longitude-deg 0");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("latitude_deg"));
  EXPECT_EQ(Dcloc(At("map coverage") + "--latitude-deg 1").exit_code, 2);
  EXPECT_EQ(Dcloc(At("map coverage") + "--map town").exit_code, 2);

  result = Dcloc(At("map download") + "--map town --out " + File("copy"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(ReadText(File("copy")), ReadText(Shared("map")));
  EXPECT_EQ(Dcloc(At("map download") + "--map city --out " + File("city")).exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(File("city")));
}

TEST_F(MapCommandsTest, AServerMakesAMapOfADrive) {
  const std::string build = At("map remote-build") + "--map town --activate " + Data();
  Result result = Dcloc(build + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto version = nlohmann::json::parse(result.out);
  EXPECT_EQ(version["version"], 1);
  EXPECT_EQ(version["active"], true);
  EXPECT_GT(version["point_count"], 100);
  const auto builds = nlohmann::json::parse(Dcloc(At("map builds") + "--json").out);
  ASSERT_EQ(builds.size(), 1U);
  EXPECT_EQ(builds[0]["state"], "done");
  EXPECT_EQ(builds[0]["done_scan_count"], builds[0]["scan_count"]);
  result = Dcloc(build + " --no-wait");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("of town: running"));
  result = Dcloc(At("map cancel-build") + "--build nobody");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("nobody"));
  EXPECT_EQ(Dcloc(Localize("--rate max")).exit_code, 0);
}

TEST_F(MapCommandsTest, AServerSurveysDrivesWithoutTheirPoses) {
  const std::string survey = At("map remote-survey") + "--map town --activate " + Data();
  Result result = Dcloc(survey + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto version = nlohmann::json::parse(result.out);
  EXPECT_EQ(version["version"], 1);
  EXPECT_EQ(version["drives"][0]["is_in_map"], true);
  const auto builds = nlohmann::json::parse(Dcloc(At("map builds") + "--json").out);
  EXPECT_EQ(builds[0]["method"], "survey");
  result = Dcloc(survey + " --to-s 0.3");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr(drive_ + ": it moved"));
  result = Dcloc(survey + ",nowhere");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("nowhere"));
  EXPECT_EQ(nlohmann::json::parse(Dcloc(At("map builds") + "--json").out).size(), 2U)
      << "nothing is built of half of the drives";
}

TEST_F(MapCommandsTest, ATileOfAMapIsPrinted) {
  Upload();
  const std::string tile = At("map tile") + "--map town ";
  const std::string all = "--min-x-m -2000 --max-x-m 2000 --min-y-m -2000 --max-y-m 2000 ";
  Result result = Dcloc(tile + all + "--json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  const auto versions = nlohmann::json::parse(Dcloc(At("map list") + "--map town --json").out);
  EXPECT_EQ(json["point_count"], versions[0]["point_count"]);
  EXPECT_EQ(json["points"].size(), json["point_count"]);
  EXPECT_EQ(json["keyframes"].size(), versions[0]["keyframe_count"]);
  EXPECT_EQ(json["points"][0].size(), 4U);
  const std::vector<std::string> csv = Lines(Dcloc(tile + all + "--max-points 100").out);
  EXPECT_EQ(csv[0], "x_m,y_m,z_m,rcs_dbsm");
  EXPECT_GT(csv.size(), 30U);
  EXPECT_LE(csv.size(), 101U);
  result = Dcloc(tile + "--min-x-m 0 --max-x-m 9000 --min-y-m 0 --max-y-m 1");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("max_x_m"));
  EXPECT_EQ(Dcloc(tile + "--min-x-m 0").exit_code, 2);
}

TEST_F(MapCommandsTest, AMapThatAServerMakesHasItsPlaceOnTheEarth) {
  ASSERT_EQ(Dcloc(At("map remote-build") + "--map town --activate --anchor 1.2986,103.78 " + Data())
                .exit_code,
            0);
  const Result result = Dcloc(
      At("map coverage") + "--latitude-deg 1.2986 --longitude-deg 103.78 --radius-m 5000 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).size(), 1U);
}

}  // namespace
}  // namespace dcloc
