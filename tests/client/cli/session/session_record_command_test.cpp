#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "tests/client/cli/fixtures/server_commands.h"

// `dcloc session record` and `replay`.
namespace dcloc {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

using SessionRecordCommandTest = ServerCommands;

TEST_F(SessionRecordCommandTest, AVehiclesRecordingIsReplayedToTheBit) {
  Upload();
  const std::string file = File("session.rec");
  ASSERT_EQ(Dcloc(Localize("--rate max --record " + file + " --trajectory-out " + File("a.tum")))
                .exit_code,
            0);
  Result result = Dcloc("session trajectory " + file + " --json --trajectory-out " + File("b.tum"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(nlohmann::json::parse(result.out)["pose_count"], 100);
  EXPECT_EQ(ReadText(File("a.tum")), ReadText(File("b.tum")));
  result = Dcloc("session trajectory " + file + " --trajectory-out " + File("b.gpx"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("the map has no anchor"));
  result = Dcloc("session replay " + file + " --json --map " + Shared("map"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto here = nlohmann::json::parse(result.out);
  EXPECT_EQ(here["vehicle_id"], "dcloc-localize");
  EXPECT_GT(here["equal_count"], 100);
  EXPECT_EQ(here["different_count"], 0);
  result = Dcloc(At("session replay") + file + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["equal_count"], here["equal_count"]);

  ASSERT_EQ(Dcloc("map build --dataset nuscenes --root " + Shared("sim") + " --drive map --out " +
                  File("other"))
                .exit_code,
            0);
  result = Dcloc("session replay " + file + " --map " + File("other"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("answers differ"));
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  result = Dcloc("session replay " + file + " --map " + Shared("map"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, ::testing::AllOf(HasSubstr(file), HasSubstr("is cut off")));
  EXPECT_EQ(Dcloc("session replay " + file).exit_code, 2) << "neither map nor server";
  EXPECT_EQ(Dcloc(At("session replay") + file + " --map " + Shared("map")).exit_code, 2);
}

TEST_F(SessionRecordCommandTest, ASessionThatBeganWithAFixIsReplayedToTheBit) {
  const std::string anchor = "--anchor 1.2986,103.78,10,30 ";
  Result result = Dcloc("map build " + Data() + " " + anchor + "--json --out " + File("anchored"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NEAR(nlohmann::json::parse(result.out)["anchor"]["x_axis_east_rad"], 0.5236, 1e-4);
  ASSERT_EQ(Dcloc(At("map upload") + "--map town --activate " + File("anchored")).exit_code, 0);
  const auto versions = nlohmann::json::parse(Dcloc(At("map list") + "--map town --json").out);
  EXPECT_NEAR(versions[0]["anchor"]["latitude_deg"], 1.2986, 1e-9);

  const std::string file = File("session.rec");
  result = Dcloc(Localize("--rate max --initial gnss " + anchor + "--record " + file));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  result = Dcloc("session replay " + file + " --json --map " + File("anchored"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto here = nlohmann::json::parse(result.out);
  EXPECT_GT(here["equal_count"], 100);
  EXPECT_EQ(here["different_count"], 0);
  EXPECT_EQ(Dcloc(At("session replay") + file).exit_code, 0);
  result = Dcloc("session replay " + file + " --any-map --map " + Shared("map"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("no anchor"));

  EXPECT_EQ(Dcloc(Localize("--initial gnss")).exit_code, 2) << "a fix needs an anchor";
  EXPECT_EQ(Dcloc(Localize(anchor)).exit_code, 2) << "and an anchor is for nothing else";
  result = Dcloc(Localize("--initial gnss --anchor 91,0"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("latitude_deg is 91"));
  EXPECT_EQ(Dcloc(Localize("--initial gnss --anchor 1")).exit_code, 2);
}

TEST_F(SessionRecordCommandTest, AnOperatorRecordsTheNextSessionOfAVehicle) {
  Upload();
  const std::string file = File("session.rec");
  DclocProcess record(At("session record") + "--vehicle dcloc-localize --json --out " + file +
                      " --trajectory-out " + File("way.csv"));
  while (record.Err().find("waiting") == std::string::npos) {
    ASSERT_FALSE(record.HasEnded()) << record.Err();
    std::this_thread::sleep_for(20ms);
  }
  ASSERT_EQ(Dcloc(Localize("--rate max --initial none")).exit_code, 0);
  Result result = record.Wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(nlohmann::json::parse(result.out)["scan_count"], 100);
  EXPECT_GT(Lines(ReadText(File("way.csv"))).size(), 100U);
  result = Dcloc("session replay " + file + " --json --map " + Shared("map"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(nlohmann::json::parse(result.out)["equal_count"], 100);

  ASSERT_EQ(Dcloc("map build --dataset nuscenes --root " + Shared("sim") + " --drive map --out " +
                  File("other"))
                .exit_code,
            0);
  result = Dcloc("session replay " + file + " --map " + File("other"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("is not the map of the recording")) << "known by its hash";
}

TEST_F(SessionRecordCommandTest, ARecordingThatIsStoppedBeforeASessionCameIsAnError) {
  DclocProcess record(At("session record") + "--vehicle nobody --out " + File("none.rec"));
  while (record.Err().find("waiting") == std::string::npos) std::this_thread::sleep_for(20ms);
  record.Signal(SIGINT);
  const Result result = record.Wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("nothing recorded"));
  EXPECT_FALSE(std::filesystem::exists(File("none.rec")));
}

}  // namespace
}  // namespace dcloc
