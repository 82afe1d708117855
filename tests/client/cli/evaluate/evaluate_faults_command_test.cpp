#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/client/cli/fixtures/dcloc_process.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string FileText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(FaultsCommand, PrintsAndWritesWhatFaultsDidAndGoesOnWhereItWas) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder.path() / "out";
  const std::string command = "evaluate faults --quick --seed 3 --out " + out.string();
  const Result first = Dcloc(command);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.err, IsEmpty());  // no progress where stderr is no terminal
  EXPECT_THAT(first.out, HasSubstr("carried 20 m ahead"));
  EXPECT_THAT(first.out, HasSubstr("with an error above their protection level"));
  EXPECT_THAT(FileText(out / "report.html"), HasSubstr("By world"));

  const std::string written = FileText(out / "results.json");
  const auto json = nlohmann::json::parse(written);
  ASSERT_EQ(json["faults"].size(), 6U);
  EXPECT_EQ(json["faults"][0]["id"], "undisturbed");
  for (const auto& fault : json["faults"]) {
    EXPECT_GT(fault["scans"], 400) << fault["id"];
    EXPECT_EQ(fault["wrong"], 0) << fault["id"];
  }

  // Only what is missing is done again.
  const auto kept = out / "runs" / "town-1.place-skipped-20m.json";
  const auto missing = out / "runs" / "town-1.movers-truck-along.json";
  ASSERT_TRUE(std::filesystem::exists(kept));
  ASSERT_TRUE(std::filesystem::remove(missing));
  const auto time = std::filesystem::last_write_time(kept);
  ASSERT_EQ(Dcloc(command + " --jobs 2").exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(missing));
  EXPECT_EQ(std::filesystem::last_write_time(kept), time);
  const Result some = Dcloc(command + " --only place,town --json");
  EXPECT_EQ(nlohmann::json::parse(some.out)["faults"].size(), 2U);
  EXPECT_EQ(FileText(out / "results.json"), some.out);
}

TEST(FaultsCommand, SaysWhatItCannotUse) {
  const TemporaryFolder folder;
  const std::string out = " --out " + (folder.path() / "out").string();
  EXPECT_EQ(Dcloc("evaluate faults").exit_code, 2);
  const Result seed = Dcloc("evaluate faults --seed -1" + out);
  EXPECT_EQ(seed.exit_code, 2);
  EXPECT_THAT(seed.err, HasSubstr("--seed: Value -1 not in range 0 to 1000000"));
  const Result jobs = Dcloc("evaluate faults --jobs 0" + out);
  EXPECT_EQ(jobs.exit_code, 2);
  EXPECT_THAT(jobs.err, HasSubstr("--jobs: Value 0 not in range 1 to 256"));
  const Result only = Dcloc("evaluate faults --quick --only highway" + out);
  EXPECT_EQ(only.exit_code, 1);
  EXPECT_THAT(only.err, HasSubstr("only is 'highway'; it must be one of town, velocity"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
  std::ofstream(folder.path() / "file") << "no folder";
  const Result taken = Dcloc("evaluate faults --quick --out " + (folder.path() / "file").string());
  EXPECT_EQ(taken.exit_code, 1);
  EXPECT_THAT(taken.err, HasSubstr("file"));
}

}  // namespace
}  // namespace dcloc
