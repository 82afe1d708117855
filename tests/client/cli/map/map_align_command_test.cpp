#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

/// Two maps of a town, of different drives.
class MapAlignCommandTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder();
    const Result town = Dcloc("simulate --length-m 400 --seed 4 --out " + File("town"));
    ASSERT_EQ(town.exit_code, 0) << town.err;
    for (const char* drive : {"map", "live-0"}) {
      const Result map = Dcloc("map build --dataset nuscenes --root " + File("town") + " --drive " +
                               drive + " --out " + File(std::string(drive) + ".dclm"));
      ASSERT_EQ(map.exit_code, 0) << map.err;
    }
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string File(const std::string& name) { return (folder_->path() / name).string(); }
  static std::string Write(const std::string& name, const std::string& text) {
    std::ofstream(File(name)) << text;
    return File(name);
  }

  static inline TempFolder* folder_ = nullptr;
};

TEST_F(MapAlignCommandTest, ControlPointsTieAMapToTheEarth) {
  const std::string points = Write("points.csv",
                                   "x_m,y_m,latitude_deg,longitude_deg,height_m\n0,0,48,9,300\n"
                                   "1000,0,48,9.0134127,300\n0,1000,48.0089931,9,300\n");
  const Result result = Dcloc("map align " + File("map.dclm") + " --control " + points + " --out " +
                              File("tied.dclm") + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["control_points"].size(), 3U);
  EXPECT_LT(json["control_points"][1]["residual_m"], 2.0);
  EXPECT_NEAR(json["map"]["anchor"]["latitude_deg"].get<double>(), 48.0, 1e-4);
  EXPECT_NEAR(json["map"]["anchor"]["x_axis_east_rad"].get<double>(), 0.0, 2e-3);
}

TEST_F(MapAlignCommandTest, AMapIsBroughtIntoAnothersFrame) {
  const Result tied =
      Dcloc("map align " + File("map.dclm") + " --anchor 48,9,0,30 --out " + File("base.dclm"));
  ASSERT_EQ(tied.exit_code, 0) << tied.err;
  const Result result = Dcloc("map align " + File("live-0.dclm") + " --to " + File("base.dclm") +
                              " --out " + File("moved.dclm") + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_LT(std::abs(json["shift_m"][0].get<double>()), 0.5) << "both were built in one frame";
  EXPECT_LT(json["rms_m"], 0.3);
  EXPECT_EQ(json["map"]["anchor"]["latitude_deg"], 48.0);
}

TEST_F(MapAlignCommandTest, WhatIsWrongIsSaidByNameAndNothingIsWritten) {
  const std::string align = "map align " + File("map.dclm") + " --out " + File("none.dclm") + " ";
  EXPECT_EQ(Dcloc(align).exit_code, 2) << "one of the three is needed";
  EXPECT_THAT(Dcloc(align + "--control " + Write("bad.csv", "x,y\n")).err,
              HasSubstr("bad.csv, line 1"));
  EXPECT_THAT(
      Dcloc(align + "--control " +
            Write("far.csv", "x_m,y_m,latitude_deg,longitude_deg\n0,0,91,9\n"))
          .err,
      HasSubstr("far.csv, line 2: latitude_deg is \"91\"; it must be a number in [-90, 90]"));
  EXPECT_THAT(Dcloc(align + "--control " +
                    Write("one.csv", "x_m,y_m,latitude_deg,longitude_deg\n0,0,48,9\n"))
                  .err,
              HasSubstr("one.csv: there are 1 control points; two at least"));
  EXPECT_THAT(Dcloc(align + "--to " + File("no.dclm")).err, HasSubstr("no.dclm"));
  EXPECT_NE(Dcloc("map inspect " + File("none.dclm")).exit_code, 0);
}

}  // namespace
}  // namespace dcloc
