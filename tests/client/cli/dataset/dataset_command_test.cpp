// `dcloc dataset` on a simulated drive and on bags made of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "client/datasets/dataset.h"
#include "client/datasets/export_bag.h"
#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;

std::string ContentsOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class DatasetCommandTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = std::make_unique<TempFolder>();
    const Result result = Dcloc("simulate --length-m 150 --out " + Sim());
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  static void TearDownTestSuite() { shared_.reset(); }

  static std::string Sim() { return (shared_->path() / "sim").string(); }
  static std::string Data() { return "--dataset nuscenes --root " + Sim() + " --drive live-0 "; }
  std::string File(const std::string& name) const { return (folder_.path() / name).string(); }

  /// The simulated drive as it would be if its range rates were `factor` times as large.
  void ExportScaled(float factor,
                    rosbag::Compression compression = rosbag::Compression::kLz4) const {
    absl::StatusOr<Drive> drive =
        ReadDrive({DatasetFormat::kNuScenes, Sim(), ""}, {.name = "live-0"});
    ASSERT_TRUE(drive.ok()) << drive.status();
    for (DriveScan& entry : drive->scans) {
      for (float& rate : entry.scan.range_rate_mps) rate *= factor;
    }
    const absl::Status status = ExportBag(*drive, File("live.bag"), compression);
    ASSERT_TRUE(status.ok()) << status;
  }

  static inline std::unique_ptr<TempFolder> shared_;
  const TempFolder folder_;
};

TEST_F(DatasetCommandTest, AFolderListsItsDrivesAndADriveIsDescribed) {
  const Result list = Dcloc("dataset inspect " + Sim());
  EXPECT_EQ(list.exit_code, 0) << list.err;
  EXPECT_THAT(list.out, ::testing::AllOf(HasSubstr("nuscenes"), HasSubstr("  live-0\n")));
  EXPECT_THAT(Json::parse(Dcloc("dataset inspect --json " + Sim()).out)["drives"],
              ::testing::Contains("map"));

  const Result drive = Dcloc("dataset inspect " + Data());
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  EXPECT_THAT(drive.out, HasSubstr("drive live-0: "));
  EXPECT_THAT(drive.out, HasSubstr("poses: reference"));
  EXPECT_THAT(drive.out, HasSubstr("positive for what recedes"));
  const Json told = Json::parse(Dcloc("dataset inspect --json " + Data()).out)["drive"];
  EXPECT_EQ(told["radars"][0]["range_rates"], "away");
  EXPECT_GT(told["radars"][0]["rate_hz"], 5.0);
}

TEST_F(DatasetCommandTest, ABagIsDescribedWithTheMappingThatFits) {
  const Result made = Dcloc("dataset export " + Data() + "--json --bag " + File("live.bag"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Result inspected = Dcloc("dataset inspect --json " + File("live.bag"));
  ASSERT_EQ(inspected.exit_code, 0) << inspected.err;
  const Json told = Json::parse(inspected.out);
  EXPECT_EQ(told["drive"]["scan_count"], Json::parse(made.out)["scan_count"]);
  EXPECT_TRUE(told["mapping_is_sound"]);
  EXPECT_EQ(told["mapping"]["motion_topic"], "/vehicle/velocity");
  EXPECT_THAT(Dcloc("dataset inspect " + File("live.bag")).out,
              ::testing::AllOf(HasSubstr("sensor_msgs/PointCloud2"), HasSubstr("fields of /radar/"),
                               HasSubstr("\"range_rate\": \"range_rate\"")));
}

TEST_F(DatasetCommandTest, TheProposedMappingMendsSigns) {
  ExportScaled(-1.0F);
  const Result wrong =
      Dcloc("dataset inspect " + File("live.bag") + " --write-mapping " + File("dcloc_bag.json"));
  ASSERT_EQ(wrong.exit_code, 0) << wrong.err;
  EXPECT_THAT(wrong.out, HasSubstr("positive for what comes nearer"));
  EXPECT_THAT(wrong.out, HasSubstr("does not fit the data"));
  EXPECT_TRUE(
      Json::parse(ContentsOf(File("dcloc_bag.json")))["radars"][0]["range_rate_is_towards"]);
  const Json mended = Json::parse(Dcloc("dataset inspect --json " + File("live.bag")).out);
  EXPECT_EQ(mended["drive"]["radars"][0]["range_rates"], "away");
  EXPECT_TRUE(mended["mapping_is_sound"]);
}

TEST_F(DatasetCommandTest, RangeRatesOverGroundAreFound) {
  ExportScaled(0.0F);
  const Json told = Json::parse(Dcloc("dataset inspect --json " + File("live.bag")).out);
  EXPECT_EQ(told["drive"]["radars"][0]["range_rates"], "compensated");
  EXPECT_TRUE(told["proposed_mapping"]["radars"][0]["range_rate_is_compensated"]);
}

TEST_F(DatasetCommandTest, WhatIsBrokenIsNamed) {
  ExportScaled(1.0F, rosbag::Compression::kNone);
  const std::string bag = File("live.bag");
  std::filesystem::resize_file(bag, std::filesystem::file_size(bag) / 2);
  const Result cut = Dcloc("dataset inspect " + bag);
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_THAT(cut.out, HasSubstr("cut off at byte "));
  EXPECT_THAT(cut.err, HasSubstr("cut off at byte "));

  std::ofstream(File("dcloc_bag.json")) << R"({"radars": [{"id": "a", "topic": "/no", "x": "x",
      "y": "y", "range_rate": "v"}]})";
  const Result missing = Dcloc("dataset inspect --json " + bag);
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.err, ::testing::AllOf(HasSubstr(bag), HasSubstr("topic /no")));
  const Json told = Json::parse(missing.out);
  EXPECT_THAT(told["error"], HasSubstr("topic /no"));
  EXPECT_FALSE(told["bag"]["topics"].empty()) << "what the bag has is told all the same";

  std::filesystem::remove(File("dcloc_bag.json"));
  std::filesystem::resize_file(bag, 5000);
  EXPECT_THAT(Dcloc("dataset inspect " + bag).err, HasSubstr("has no message before byte "));
  std::ofstream(File("no.bag")) << "no bag";
  EXPECT_THAT(Dcloc("dataset inspect " + File("no.bag")).err, HasSubstr("is no bag"));
  EXPECT_EQ(Dcloc("dataset inspect " + File("none.bag")).exit_code, 2);
  std::ofstream(File("drive.mcap")) << "\x89MCAP0";
  EXPECT_THAT(Dcloc("dataset inspect " + File("drive.mcap")).err, HasSubstr("is an MCAP file"));
  const Result nowhere = Dcloc("dataset export " + Data() + "--bag " + File("nowhere/a.bag"));
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_THAT(nowhere.err, HasSubstr("nowhere/a.bag: "));
  EXPECT_EQ(Dcloc("dataset inspect").exit_code, 2);
  const TempFolder empty;
  const Result nothing = Dcloc("dataset inspect " + empty.path().string());
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("holds no v1.0-* folder"));
  EXPECT_THAT(Dcloc("dataset inspect " + Data() + "--write-mapping " + File("m")).err,
              HasSubstr("--write-mapping: only bags"));
}

TEST_F(DatasetCommandTest, ReferencePosesAreWrittenWholeOrNotAtAll) {
  const std::string command = "dataset trajectory " + Data() + "--trajectory-out ";
  const Result made = Dcloc(command + File("truth.tum --json"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string tum = ContentsOf(File("truth.tum"));
  EXPECT_EQ(Json::parse(made.out)["pose_count"], std::count(tum.begin(), tum.end(), '\n'));
  ASSERT_EQ(Dcloc(command + File("truth.gpx --anchor 48.1,11.6")).exit_code, 0);
  EXPECT_THAT(ContentsOf(File("truth.gpx")), HasSubstr("<name>live-0</name>"));
  EXPECT_EQ(Dcloc(command + File("poses --trajectory-format kitti")).exit_code, 0);

  const Result no_anchor = Dcloc(command + File("other.geojson"));
  EXPECT_EQ(no_anchor.exit_code, 1);
  EXPECT_THAT(no_anchor.err, ::testing::AllOf(HasSubstr("other.geojson"), HasSubstr("anchor")));
  const Result unknown = Dcloc(command + File("truth.xyz"));
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err, ::testing::AllOf(HasSubstr("truth.xyz"), HasSubstr("tum, kitti, csv")));
  EXPECT_FALSE(std::filesystem::exists(File("other.geojson")));
  EXPECT_FALSE(std::filesystem::exists(File("truth.xyz")));
}

}  // namespace
}  // namespace dcloc
