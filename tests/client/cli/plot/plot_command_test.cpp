// `dcloc plot` on trajectories that the test writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_format.h"
#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;

class PlotCommandTest : public ::testing::Test {
 protected:
  std::string File(const std::string& name) const { return (folder_.path() / name).string(); }

  /// A straight way, `left_m` beside the true one.
  void WriteWay(const std::string& name, double left_m) const {
    std::ofstream file(File(name));
    for (int i = 0; i < 50; ++i) {
      file << absl::StrFormat("%d.5 %d %.3f 0 0 0 0 1\n", 1'714'557'600 + i, 10 * i, left_m);
    }
  }

  const TempFolder folder_;
};

TEST_F(PlotCommandTest, ErrorsAreToldAndDrawn) {
  WriteWay("truth.tum", 0.0);
  WriteWay("it's <near> & a `name`.tum", 0.25);
  const std::string files =
      "\"" + File("it's <near> & a \\`name\\`.tum") + "\" --reference " + File("truth.tum") + " ";
  const Result result = Dcloc("plot " + files + "--json --out " + File("out.svg"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json told = Json::parse(result.out);
  EXPECT_EQ(told[0]["compared_count"], 50);
  EXPECT_NEAR(told[0]["position_error_m"]["rms"].get<double>(), 0.25, 1e-6);
  EXPECT_TRUE(std::filesystem::exists(File("out.svg")));
  ASSERT_EQ(Dcloc("plot " + files + "--out " + File("out.png")).exit_code, 0);
  EXPECT_GT(std::filesystem::file_size(File("out.png")), 1000U);
  EXPECT_FALSE(std::filesystem::exists(File("out.png.part")));
  const Json aligned = Json::parse(Dcloc("plot " + files + "--align --json").out);
  EXPECT_NEAR(aligned[0]["position_error_m"]["max"].get<double>(), 0.0, 1e-6);
}

TEST_F(PlotCommandTest, ASinglePoseAndNoReferenceAreDrawnToo) {
  std::ofstream(File("one.tum")) << "1.5 7 7 0 0 0 0 1\n";
  const Result result = Dcloc("plot " + File("one.tum") + " --out " + File("one.png"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(std::filesystem::exists(File("one.png")));
}

TEST_F(PlotCommandTest, WhatCannotBeComparedIsNamed) {
  WriteWay("truth.tum", 0.0);
  std::ofstream(File("empty.tum")).flush();
  std::ofstream(File("late.tum")) << "9.5 7 7 0 0 0 0 1\n";
  std::ofstream(File("broken.tum")) << "9.5 7 7\n";
  std::ofstream(File("way.xyz")) << "9.5 7 7 0 0 0 0 1\n";
  const auto error = [&](const std::string& words) {
    const Result result =
        Dcloc("plot " + words + " --reference " + File("truth.tum") + " --out " + File("out.png"));
    EXPECT_EQ(result.exit_code, 1) << words;
    return result.err;
  };
  EXPECT_THAT(error(File("empty.tum")), HasSubstr("empty.tum: has no pose"));
  EXPECT_THAT(error(File("late.tum")), HasSubstr("none of its stamps"));
  EXPECT_THAT(error(File("broken.tum")), HasSubstr("broken.tum: line 1: has 3 values"));
  EXPECT_THAT(error(File("way.xyz")), HasSubstr("tum, kitti, csv"));
  EXPECT_THAT(error(File("nowhere.tum")), HasSubstr("nowhere.tum"));
  EXPECT_THAT(error(File("") + " --format tum"), HasSubstr("is a folder"));
  EXPECT_FALSE(std::filesystem::exists(File("out.png")));
  EXPECT_EQ(Dcloc("plot " + File("truth.tum")).exit_code, 2) << "nothing to do";
  EXPECT_EQ(Dcloc("plot " + File("truth.tum") + " --out a.jpg").exit_code, 2);
  EXPECT_EQ(Dcloc("plot " + File("truth.tum") + " --align --out a.png").exit_code, 2);
}

}  // namespace
}  // namespace dcloc
