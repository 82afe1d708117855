#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

class SimulateCommandTest : public ::testing::Test {
 protected:
  Result Simulate(const std::string& options, const std::string& name = "sim") const {
    return Dcloc("simulate --length-m 60 " + options + " --out " + Path(name));
  }
  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }

  const TempFolder folder_;
};

TEST_F(SimulateCommandTest, EachLiveSpeedIsADriveAndFixesStandBesideIt) {
  const Result result = Simulate("--live-speed-kmh 30,50 --fixes 2");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* drive : {"map", "live-0", "live-1"}) {
    const std::string fixes = ReadText(Path("sim/fixes") + "/" + drive + ".csv");
    EXPECT_GT(std::count(fixes.begin(), fixes.end(), '\n'), 5) << drive;
  }
  EXPECT_FALSE(std::filesystem::exists(Path("sim/fixes/live-2.csv")));
}

TEST_F(SimulateCommandTest, OneSeedMakesOneWorldToTheByte) {
  ASSERT_EQ(Simulate("--seed 5 --fixes 2", "a").exit_code, 0);
  ASSERT_EQ(Simulate("--seed 5 --fixes 2", "b").exit_code, 0);
  ASSERT_EQ(Simulate("--seed 6 --fixes 2", "c").exit_code, 0);
  EXPECT_EQ(ReadText(Path("a/fixes/live-0.csv")), ReadText(Path("b/fixes/live-0.csv")));
  EXPECT_NE(ReadText(Path("a/fixes/live-0.csv")), ReadText(Path("c/fixes/live-0.csv")));
}

TEST_F(SimulateCommandTest, WhatIsThereIsNotLost) {
  folder_.Write("sim/notes.txt", "mine");
  EXPECT_EQ(Simulate("").exit_code, 1);
  EXPECT_EQ(Simulate("--force").exit_code, 0);
  EXPECT_EQ(ReadText(Path("sim/notes.txt")), "mine");
}

TEST_F(SimulateCommandTest, OptionsThatMakeNoSenseAreNamed) {
  EXPECT_EQ(Simulate("--world desert").exit_code, 2);
  const Result negative = Simulate("--clutter -0.1");
  EXPECT_NE(negative.exit_code, 0);
  EXPECT_THAT(negative.err, HasSubstr("clutter"));
  EXPECT_NE(Simulate("--noise student").exit_code, 0);  // which needs --radar carla
  EXPECT_FALSE(std::filesystem::exists(Path("sim")));
}

}  // namespace
}  // namespace dcloc
