#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/cli/fixtures/server_commands.h"

// `dcloc localize`.
namespace dcloc {
namespace {

using ::testing::HasSubstr;

using LocalizeCommandTest = ServerCommands;

TEST_F(LocalizeCommandTest, ADriveIsLocalizedAndTheAnswersAreKept) {
  Upload();
  const Result result = Dcloc(Localize("--rate max --tum " + File("answers.txt")));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("RTE mean"));
  ExpectWholeLines();
  const std::vector<std::string> csv = Lines(ReadText(File("answers.csv")));
  EXPECT_THAT(result.out, HasSubstr(std::to_string(csv.size() - 1) + " of " +
                                    std::to_string(csv.size() - 1) + " scans were answered"));
  EXPECT_EQ(csv[0].rfind("stamp_ns,radar,state,x,y,z,qx,qy,qz,qw,c00,c01,", 0), 0U);
  EXPECT_THAT(csv[0], HasSubstr(",c54,c55,latency_ms,map_version"));
  const auto tracking = std::ranges::count_if(
      csv, [](const std::string& line) { return line.find(",TRACKING,") != std::string::npos; });
  EXPECT_GT(tracking, static_cast<long>(csv.size() / 2));
  const std::vector<std::string> tum = Lines(ReadText(File("answers.txt")));
  EXPECT_GE(tum.size(), static_cast<std::size_t>(tracking));
  EXPECT_EQ(std::ranges::count(tum[0], ' '), 7);

  const auto json = nlohmann::json::parse(Dcloc(Localize("--rate max --json")).out);
  EXPECT_EQ(json["scan_count"], csv.size() - 1);
  EXPECT_EQ(json["refused"], 0);
  EXPECT_LT(json["rte_m"]["median"], 0.2);
}

TEST_F(LocalizeCommandTest, CtrlCKeepsWhatWasAnswered) {
  Upload();
  DclocProcess localize(Localize("--rate realtime"));
  WaitForAnswers();
  localize.Signal(SIGINT);
  const Result result = localize.Wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("interrupted"));
  EXPECT_THAT(result.out, HasSubstr("scans were answered"));
  ExpectWholeLines();
}

TEST_F(LocalizeCommandTest, AServerThatStopsIsAnErrorThatKeepsWhatWasAnswered) {
  Upload();
  DclocProcess localize(Localize("--rate realtime --reconnect-s 0"));
  WaitForAnswers();
  server_.reset();
  const Result result = localize.Wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("dcloc: "));
  ExpectWholeLines();
}

TEST_F(LocalizeCommandTest, ErrorsSayWhatIsWrongAndTouchNoFile) {
  std::ofstream(File("answers.csv")) << "old";
  Result result = Dcloc(Localize("--rate max"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("town"));
  server_.reset();
  result = Dcloc(Localize("--rate max"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr(address_));
  result = Dcloc(Localize("--trajectory-out " + File("way.xyz")));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("way.xyz"));
  result = Dcloc(Localize("--rate max --tls-ca " + File("missing.pem")));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("missing.pem"));
  EXPECT_EQ(ReadText(File("answers.csv")), "old");
  EXPECT_EQ(Dcloc("map list --server nowhere").exit_code, 1);
  EXPECT_EQ(Dcloc(Localize("--rate sometimes")).exit_code, 2);
}

TEST_F(LocalizeCommandTest, FixesGoAmongTheScansAndAreReplayedToTheBit) {
  Upload();
  const std::string fixes = Shared("sim") + "/fixes/" + drive_ + ".csv";
  const std::string recording = File("session.rec");
  Result result = Dcloc(Localize("--rate max --json --fixes " + fixes + " --record " + recording));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  std::size_t fix_count = 0;
  for (const auto& [use, count] : json["fixes"].items()) fix_count += count.get<std::size_t>();
  EXPECT_GE(fix_count, Lines(ReadText(fixes)).size() - 2) << "the last may come after all scans";
  EXPECT_EQ(json["first_invalid_fix"], "");
  EXPECT_EQ(json["refused"], 0);
  result = Dcloc("session replay " + recording + " --json --map " + Shared("map"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["fix_count"], fix_count);
  EXPECT_EQ(Dcloc(At("session replay") + recording).exit_code, 0);
}

TEST_F(LocalizeCommandTest, FixesThatCannotBeSentAreNamed) {
  Upload();
  const std::string file = File("fixes.csv");
  std::ofstream(file) << "stamp_ns,latitude_deg,longitude_deg,height_m,horizontal_sigma_m,"
                         "vertical_sigma_m\n1714557600000000000,48,10,0,1,1\n";
  Result result = Dcloc(Localize("--rate max --fixes " + file));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, ::testing::AllOf(HasSubstr(file), HasSubstr("no anchor")));
  std::ofstream(file, std::ios::app) << "1714557600000000000,99,10,0,1,1\n";
  result = Dcloc(Localize("--rate max --fixes " + file));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, ::testing::AllOf(HasSubstr("line 3"), HasSubstr("latitude_deg is 99")));
}

}  // namespace
}  // namespace dcloc
