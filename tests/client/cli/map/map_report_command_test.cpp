#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

/// A town with a tunnel.
class MapReportCommandTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder();
    const Result town =
        Dcloc("simulate --length-m 500 --tunnel-m 200 --seed 4 --out " + File("town"));
    ASSERT_EQ(town.exit_code, 0) << town.err;
    const Result map = Dcloc("map build --dataset nuscenes --root " + File("town") +
                             " --drive map --out " + File("town.dclm"));
    ASSERT_EQ(map.exit_code, 0) << map.err;
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string File(const std::string& name) { return (folder_->path() / name).string(); }

  static inline TempFolder* folder_ = nullptr;
};

TEST_F(MapReportCommandTest, TellsPlaceByPlaceAndDrawsIt) {
  const Result result = Dcloc("map report " + File("town.dclm") + " --json --out " +
                              File("town.html") + " --map-out " + File("told.dclm"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["keyframes"].size(), json["map"]["keyframe_count"].get<std::size_t>());
  EXPECT_LT(json["across_sigma_m"]["median"], 0.1);
  EXPECT_GE(json["tunnel_count"], 5) << "the tunnel is 200 m long";
  EXPECT_LE(json["tunnel_count"], 30);
  const std::string page = ReadText(File("town.html"));
  EXPECT_THAT(page, HasSubstr("<svg"));
  EXPECT_THAT(page, HasSubstr("<h2>Tunnels</h2>"));
  EXPECT_EQ(Dcloc("map inspect " + File("told.dclm")).exit_code, 0);
}

TEST_F(MapReportCommandTest, SaysWhatItFoundInWords) {
  const Result result = Dcloc("map report " + File("town.dclm") + " --alias-radius-m 0");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("across"));
  EXPECT_THAT(result.out, HasSubstr("0 look like others"));
}

TEST_F(MapReportCommandTest, ReplacesNothingAndTakesNoOtherFile) {
  const std::string page = " --out " + File("town.dclm");
  EXPECT_THAT(Dcloc("map report " + File("town.dclm") + page).err, HasSubstr("--force"));
  const Result none = Dcloc("map report " + File("town"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("town"));
  EXPECT_EQ(Dcloc("map report " + File("town.dclm") + " --radars 3").exit_code, 2);
}

}  // namespace
}  // namespace dcloc
