#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/cli/fixtures/server_commands.h"

// `dcloc load`.
namespace dcloc {
namespace {

using ::testing::HasSubstr;

using LoadCommandTest = ServerCommands;

TEST_F(LoadCommandTest, AServerIsLoadedAndEachAnswerIsJudged) {
  Upload();
  const std::string load = At("load") + "--map town " + Data() + " --ramp-s 0.5 --warmup-s 0.5 ";
  Result result = Dcloc(load + "--vehicles 3 --duration-s 3 --target-p99-ms 5000 --json --plot " +
                        File("latency.png"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["held"], true);
  EXPECT_EQ(json["totals"]["lost_count"], 0);
  EXPECT_GT(json["totals"]["answered_count"], 60);
  EXPECT_GT(json["totals"]["judged_count"], 0) << "poses are compared with the truth";
  EXPECT_LT(json["totals"]["mean_error_m"], 1.0);
  EXPECT_GT(std::filesystem::file_size(File("latency.png")), 1000U);

  result = Dcloc(load + "--vehicles 2 --duration-s 2 --target-p99-ms 0.001");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("the target is 0.001 ms"));
  EXPECT_THAT(result.out, HasSubstr("scans/s"));

  result = Dcloc(load +
                 "--vehicles 1 --max-vehicles 2 --search --target-p99-ms 5000 "
                 "--duration-s 2 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["vehicle_count"], 2);
  EXPECT_EQ(Dcloc(load + "--search").exit_code, 2) << "a search needs a target";
}

}  // namespace
}  // namespace dcloc
