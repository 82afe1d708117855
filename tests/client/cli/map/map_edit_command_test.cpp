// `dcloc map crop, remove, split, merge, diff, export, import` on the map of a simulated drive.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "client/datasets/dataset.h"
#include "client/evaluation/runner.h"
#include "core/map/editable_map.h"
#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;

std::string BytesIn(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void ExpectOk(const Result& result) { EXPECT_EQ(result.exit_code, 0) << result.err; }

class MapEditCommandTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = std::make_unique<TempFolder>();
    ExpectOk(Dcloc("simulate --length-m 250 --out " + Shared("sim")));
    ExpectOk(Dcloc("map build --dataset nuscenes --drive map --anchor 48,9,300,20 --root " +
                   Shared("sim") + " --out " + Town()));
  }
  static void TearDownTestSuite() { shared_.reset(); }

  static std::string Shared(const std::string& name) { return (shared_->path() / name).string(); }
  static std::string Town() { return Shared("town.dclm"); }
  std::string File(const std::string& name) const { return (folder_.path() / name).string(); }

  /// The answers to the live drive in a map.
  static DriveOutcome Localize(const std::string& file) {
    const auto drive = ReadDrive({DatasetFormat::kNuScenes, Shared("sim"), ""}, {.name = "live-0"});
    const auto map = RadarMap::Open(file);
    EXPECT_TRUE(drive.ok() && map.ok()) << drive.status() << map.status();
    auto outcome = Evaluate(*map, *drive, {});
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return *std::move(outcome);
  }

  static inline std::unique_ptr<TempFolder> shared_;
  const TempFolder folder_;
};

TEST_F(MapEditCommandTest, MergedHalvesLocalizeAsTheWhole) {
  ExpectOk(Dcloc("map split " + Town() + " --box -1000,-1000,120,1000 --inside " + File("west") +
                 " --outside " + File("east")));
  ExpectOk(Dcloc("map merge " + File("west") + " " + File("east") + " --out " + File("both")));
  const DriveOutcome whole = Localize(Town());
  const DriveOutcome merged = Localize(File("both"));
  ASSERT_EQ(whole.scans.size(), merged.scans.size());
  for (std::size_t i = 0; i < whole.scans.size(); ++i) {
    const Localization& a = whole.scans[i].answer;
    const Localization& b = merged.scans[i].answer;
    EXPECT_EQ(a.state, b.state) << i;
    EXPECT_LT((a.T_map_vehicle.translation_m - b.T_map_vehicle.translation_m).norm(), 1e-3) << i;
  }
  // In a half alone the other half is not there.
  const Result inspect = Dcloc("map inspect --json " + File("west"));
  EXPECT_LT(Json::parse(inspect.out)["point_count"],
            Json::parse(Dcloc("map inspect --json " + Town()).out)["point_count"]);
}

TEST_F(MapEditCommandTest, CropAndRemoveAreTheHalvesOfASplit) {
  const std::string polygon = " --polygon -50,-60,100,-60,140,80,-50,80 ";
  ExpectOk(Dcloc("map split " + Town() + polygon + "--inside " + File("in") + " --outside " +
                 File("out")));
  ExpectOk(Dcloc("map crop " + Town() + polygon + "--out " + File("crop")));
  ExpectOk(Dcloc("map remove " + Town() + polygon + "--out " + File("remove")));
  EXPECT_EQ(BytesIn(File("crop")), BytesIn(File("in")));
  EXPECT_EQ(BytesIn(File("remove")), BytesIn(File("out")));
}

TEST_F(MapEditCommandTest, ARegionMayBeDrawnOnTheEarth) {
  // About 300 m to each side of the anchor.
  const std::string region =
      folder_
          .Write("r.geojson", R"({"type":"Polygon","coordinates":[[[8.999,47.999],[9.001,47.999],
                       [9.001,48.0005],[8.999,48.0005],[8.999,47.999]]]})")
          .string();
  const Result crop =
      Dcloc("map crop " + Town() + " --region " + region + " --json --out " + File("crop"));
  ExpectOk(crop);
  const Json map = Json::parse(crop.out)[0]["map"];
  EXPECT_GT(map["point_count"], 10);
  EXPECT_LT(map["max_map_m"][0], 250.0);
  const Result far = Dcloc("map crop " + Town() + " --box 9000,0,9001,1 --out " + File("no"));
  EXPECT_EQ(far.exit_code, 1);
  EXPECT_THAT(far.err, HasSubstr("the region holds none of the map's"));
  EXPECT_FALSE(std::filesystem::exists(File("no")));
}

TEST_F(MapEditCommandTest, NothingIsReplacedWithoutBeingAsked) {
  const std::string file = folder_.Write("old.dclm", "old").string();
  const std::string crop = "map crop " + Town() + " --box -900,-900,900,900 --out " + file;
  const Result refused = Dcloc(crop);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("old.dclm: is there already; --force replaces it"));
  EXPECT_EQ(BytesIn(file), "old");
  ExpectOk(Dcloc(crop + " --force"));
  EXPECT_NE(BytesIn(file), "old");
  EXPECT_THAT(Dcloc("map split " + Town() + " --box 0,0,9,9 --inside " + File("x") + " --outside " +
                    File("x"))
                  .err,
              HasSubstr("two outputs would have this path"));
}

TEST_F(MapEditCommandTest, WhereOneOutputCannotBeWrittenNoneIs) {
  const Result split = Dcloc("map split " + Town() + " --box -1000,-1000,120,1000 --inside " +
                             File("west") + " --outside " + File("none/east"));
  EXPECT_EQ(split.exit_code, 1);
  EXPECT_THAT(split.err, HasSubstr("none/east: cannot be written: there is no folder"));
  EXPECT_FALSE(std::filesystem::exists(File("west")));
  const Result exported =
      Dcloc("map export " + Town() + " --force --landmarks " + File("a.pcd") +
            " --trajectory-format tum --trajectory-out " + folder_.path().string());
  EXPECT_EQ(exported.exit_code, 1);
  EXPECT_THAT(exported.err, HasSubstr("cannot be written: it is a folder"));
  EXPECT_FALSE(std::filesystem::exists(File("a.pcd")));
}

TEST_F(MapEditCommandTest, NoAnchorIsLostInAMerge) {
  auto map = RadarMap::Open(Town());
  ASSERT_TRUE(map.ok()) << map.status();
  EditableMap parts = ToEditable(**map);
  parts.info.flags &= ~kHasAnchorFlag;
  parts.info.anchor_latitude_deg = parts.info.anchor_longitude_deg = 0.0;
  parts.info.anchor_height_m = parts.info.anchor_x_axis_east_rad = 0.0;
  const auto bytes = ToMapBytes(parts);
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const std::string bare =
      folder_
          .Write("bare.dclm",
                 std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()))
          .string();
  const std::string end = " --same-frame --force --out " + File("both");
  const Result lost = Dcloc("map merge " + bare + " " + Town() + end);
  EXPECT_EQ(lost.exit_code, 1);
  EXPECT_THAT(lost.err, HasSubstr("town.dclm: has an anchor on the Earth, and"));
  ExpectOk(Dcloc("map merge " + Town() + " " + bare + end));
  EXPECT_EQ(BytesIn(File("both")), BytesIn(Town()));
}

TEST_F(MapEditCommandTest, ExportAndImportGiveTheSameMap) {
  for (const std::string file : {"town.geojson", "town.pcd"}) {
    ExpectOk(Dcloc("map export " + Town() + " --landmarks " + File(file) + " --trajectory-out " +
                   File("town.tum") + " --force"));
    const Result imported =
        Dcloc("map import --json --base " + Town() + " --landmarks " + File(file) +
              " --trajectory " + File("town.tum") + " --out " + File(file + ".dclm"));
    ExpectOk(imported);
    EXPECT_EQ(BytesIn(File(file + ".dclm")), BytesIn(Town()));
    EXPECT_EQ(Json::parse(imported.out)["landmarks"]["moved_count"], 0);
  }
}

TEST_F(MapEditCommandTest, MendedLandmarksAreWhatDiffTells) {
  ExpectOk(Dcloc("map export " + Town() + " --landmarks " + File("town.geojson")));
  Json json = Json::parse(BytesIn(File("town.geojson")));
  Json& features = json["features"];
  const std::size_t count = features.size();
  features.erase(3);
  features[10]["geometry"]["coordinates"][1] =
      features[10]["geometry"]["coordinates"][1].get<double>() + 1.3e-4;  // 14 m to the north
  folder_.Write("mended.geojson", json.dump());
  ExpectOk(Dcloc("map import --base " + Town() + " --landmarks " + File("mended.geojson") +
                 " --out " + File("mended.dclm")));
  const Result diff = Dcloc("map diff --json " + Town() + " " + File("mended.dclm") +
                            " --same-m 0.05 --moved-m 0.05");
  ExpectOk(diff);
  const Json found = Json::parse(diff.out);
  EXPECT_EQ(found["same_count"], count - 2);
  EXPECT_GT(found["went"].size(), 0U);
  EXPECT_EQ(found["went"].size() + found["only_old_covers_count"].get<std::size_t>(), 2U);
  EXPECT_EQ(found["came"].size() + found["only_new_covers_count"].get<std::size_t>(), 1U);
}

TEST_F(MapEditCommandTest, ADiffIsDrawn) {
  ExpectOk(Dcloc("map remove " + Town() + " --box 50,-30,80,30 --out " + File("less.dclm")));
  const Result diff =
      Dcloc("map diff " + Town() + " " + File("less.dclm") + " --picture " + File("diff.svg"));
  ExpectOk(diff);
  EXPECT_THAT(diff.out, HasSubstr("came         0"));
  const Result counted = Dcloc("map diff --json " + Town() + " " + File("less.dclm"));
  EXPECT_GT(Json::parse(counted.out)["went"].size(), 0U);
  EXPECT_THAT(BytesIn(File("diff.svg")), HasSubstr("went: "));
}

TEST_F(MapEditCommandTest, WrongUsageIsSaid) {
  EXPECT_EQ(Dcloc("map crop " + Town() + " --out " + File("x")).exit_code, 2);
  EXPECT_THAT(Dcloc("map crop " + Town() + " --box 1,2,3 --out " + File("x")).err,
              HasSubstr("--box: has 3 numbers; it must be 4"));
  EXPECT_THAT(Dcloc("map crop " + Town() + " --box 1,2,a,3 --out " + File("x")).err,
              HasSubstr("'a' is no number"));
  EXPECT_THAT(Dcloc("map crop " + Town() + " --box 1,1,1,3 --out " + File("x")).err,
              HasSubstr("area of 0 m^2"));
  EXPECT_THAT(Dcloc("map export " + Town() + " --landmarks " + File("x.shp")).err,
              HasSubstr("must end with .pcd"));
  const std::string broken = folder_.Write("broken.dclm", "no map").string();
  EXPECT_THAT(Dcloc("map diff " + Town() + " " + broken).err, HasSubstr("broken.dclm"));
}

}  // namespace
}  // namespace dcloc
