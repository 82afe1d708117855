#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/client/cli/fixtures/dcloc_process.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string TextOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(RobustnessCommand, PrintsAndWritesWhereTheGoalsStandAndGoesOnWhereItWas) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder.path() / "out";
  const std::string command = "evaluate robustness --quick --seed 3 --out " + out.string();
  const Result first = Dcloc(command);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.err, IsEmpty());  // no progress where stderr is no terminal
  EXPECT_THAT(first.out, HasSubstr("10 scans, displaced copy"));
  EXPECT_THAT(first.out, HasSubstr("from a GNSS fix of 3 m, no heading"));
  EXPECT_THAT(first.out, HasSubstr("missed"));  // too few scans for the goal of misleading ones
  EXPECT_THAT(TextOf(out / "report.html"), HasSubstr("Robustness"));

  const auto json = nlohmann::json::parse(TextOf(out / "results.json"));
  ASSERT_EQ(json["rows"].size(), 10U);
  for (const auto& row : json["rows"]) {
    EXPECT_GT(row["scans"], 20) << row["id"];
    EXPECT_EQ(row["misleading"], 0) << row["id"];
  }

  // Only what is missing is done again.
  const auto kept = out / "runs" / "ars408-town-4001-40kmh.gap.json";
  const auto missing = out / "runs" / "ars408-town-4001-40kmh.empty.json";
  ASSERT_TRUE(std::filesystem::exists(kept));
  ASSERT_TRUE(std::filesystem::remove(missing));
  const auto written = std::filesystem::last_write_time(kept);
  const Result again = Dcloc(command);
  EXPECT_EQ(again.out, first.out);
  EXPECT_TRUE(std::filesystem::exists(missing));
  EXPECT_EQ(std::filesystem::last_write_time(kept), written);
}

TEST(RobustnessCommand, SaysWhatItCannotUse) {
  const TemporaryFolder folder;
  const std::string out = " --out " + (folder.path() / "out").string();
  EXPECT_EQ(Dcloc("evaluate robustness").exit_code, 2);
  EXPECT_EQ(Dcloc("evaluate robustness --seed -1" + out).exit_code, 2);
  const Result empty = Dcloc("evaluate robustness --quick --data " + folder.path().string() + out);
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.err, HasSubstr("holds neither nuScenes tables"));
  std::ofstream(folder.path() / "file") << "no folder";
  const Result taken =
      Dcloc("evaluate robustness --quick --out " + (folder.path() / "file").string());
  EXPECT_EQ(taken.exit_code, 1);
  EXPECT_THAT(taken.err, HasSubstr("file"));
}

}  // namespace
}  // namespace dcloc
