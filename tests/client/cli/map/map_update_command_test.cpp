#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

/// A town that aged, its map of before, and four drives of four vehicles since.
class MapUpdateCommandTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder();
    const Result town = Dcloc("simulate --length-m 400 --replaced 0.1 --vehicles 4 --seed 12 " +
                              std::string("--live-speed-kmh 50,40,60,45 --out ") + File("town"));
    ASSERT_EQ(town.exit_code, 0) << town.err;
    const Result map = Dcloc("map build " + Dataset() + " --drive map --out " + File("old.dclm"));
    ASSERT_EQ(map.exit_code, 0) << map.err;
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string File(const std::string& name) { return (folder_->path() / name).string(); }
  static std::string Dataset() { return "--dataset nuscenes --root " + File("town"); }
  static std::string Update(const std::string& drives, const std::string& out) {
    return "map update --base " + File("old.dclm") + " " + Dataset() + " --drive " + drives +
           " --out " + File(out) + " --json";
  }

  static inline TempFolder* folder_ = nullptr;
};

TEST_F(MapUpdateCommandTest, WritesABetterVersionAndAPageOfWhatChanged) {
  const Result result =
      Dcloc(Update("live-0,live-1,live-2,live-3", "new.dclm") + " --report " + File("new.html"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_TRUE(json["gate"]["is_better"]) << json["gate"]["reason"];
  EXPECT_EQ(json["gate"]["kept_out"], "live-3");
  EXPECT_GT(json["gate"]["new"]["fit"], json["gate"]["old"]["fit"]);
  EXPECT_GT(json["came"].size(), 5U);
  EXPECT_GT(json["went"].size(), 5U);
  EXPECT_THAT(json["went"][0]["since"].get<std::string>(), HasSubstr("2024-05-0"));
  EXPECT_EQ(json["passes"].size(), 3U);
  EXPECT_EQ(Dcloc("map inspect " + File("new.dclm")).exit_code, 0);
  const std::string page = ReadText(File("new.html"));
  EXPECT_THAT(page, HasSubstr("<svg"));
  EXPECT_THAT(page, HasSubstr("live-2"));
}

TEST_F(MapUpdateCommandTest, OneDriveAloneIsTooFew) {
  const Result result = Dcloc(Update("live-0,live-3", "few.dclm"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("three drives at least"));
  EXPECT_FALSE(std::filesystem::exists(File("few.dclm")));
}

TEST_F(MapUpdateCommandTest, DrivesThatDidNotMoveAreNamedAndNothingIsWritten) {
  const Result result = Dcloc(Update("live-0,live-1,live-3", "still.dclm") + " --to-s 0.5");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("live-0: it moved"));
  EXPECT_FALSE(std::filesystem::exists(File("still.dclm")));
}

TEST_F(MapUpdateCommandTest, ADriveCountsOnce) {
  const Result result = Dcloc(Update("live-0,live-0,live-3", "twice.dclm"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("--drive names live-0 twice"));
}

TEST_F(MapUpdateCommandTest, MapAndPageAreTwoFiles) {
  const Result result = Dcloc(Update("live-0,live-1,live-3", "same") + " --report " + File("same"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("--out and --report are both"));
}

TEST_F(MapUpdateCommandTest, APageWithoutItsFolderIsRefusedBeforeAnyWork) {
  const Result result =
      Dcloc(Update("live-0,live-1,live-9", "unpaged.dclm") + " --report " + File("none/new.html"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("none/new.html: cannot be written: there is no folder"));
  EXPECT_FALSE(std::filesystem::exists(File("unpaged.dclm")));
}

TEST_F(MapUpdateCommandTest, DoesNotReplaceAFile) {
  const Result result = Dcloc(Update("live-0,live-1,live-3", "old.dclm"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("old.dclm"));
}

}  // namespace
}  // namespace dcloc
