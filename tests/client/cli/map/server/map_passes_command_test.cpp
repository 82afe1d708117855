#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/cli/fixtures/server_commands.h"

// `dcloc map pass-consent` and `passes`.
namespace dcloc {
namespace {

using ::testing::HasSubstr;

using MapPassesCommandTest = ServerCommands;

TEST_F(MapPassesCommandTest, PassesAreKeptWithBothConsentsAndGoWithOne) {
  Upload();
  const std::string consent = At("map pass-consent");
  EXPECT_EQ(Dcloc(consent + "--map town").out, "given\n");
  ASSERT_EQ(Dcloc(Localize("--rate max")).exit_code, 0);
  EXPECT_EQ(Dcloc(consent + "--identity anonymous").exit_code, 0);
  const auto consents = nlohmann::json::parse(Dcloc(consent + "--list --json").out);
  ASSERT_EQ(consents.size(), 2U);
  EXPECT_EQ(consents[0]["of"], "map");
  EXPECT_EQ(consents[1]["name"], "anonymous");
  ASSERT_EQ(Dcloc(Localize("--rate max")).exit_code, 0);
  nlohmann::json passes;
  for (int i = 0; i < 100 && passes.empty(); ++i) {
    passes = nlohmann::json::parse(Dcloc(At("map passes") + "--map town --json").out);
  }
  ASSERT_EQ(passes.size(), 1U) << "the drive before had one consent only";
  EXPECT_GT(passes[0]["scan_count"], 50);
  EXPECT_EQ(passes[0]["version"], 1);
  EXPECT_THAT(Dcloc(consent + "--map town --withdraw").out, HasSubstr("1 passes removed"));
  EXPECT_EQ(nlohmann::json::parse(Dcloc(At("map passes") + "--map town --json").out).size(), 0U);
}

TEST_F(MapPassesCommandTest, WhoseConsentItIsMustBeSaidOnce) {
  for (const char* const words : {"", "--map town --identity car-1", "--list --map town"}) {
    const Result result = Dcloc(At("map pass-consent") + words);
    EXPECT_NE(result.exit_code, 0) << words;
    EXPECT_THAT(result.err, HasSubstr("one of --map, --identity and --list"));
  }
}

}  // namespace
}  // namespace dcloc
