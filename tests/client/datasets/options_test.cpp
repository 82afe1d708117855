#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/datasets/dataset.h"
#include "client/datasets/drive_map.h"
#include "client/datasets/nuscenes.h"
#include "tests/client/fixtures/field_cases.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

TEST(DriveRequestTest, EachFieldIsValidated) {
  // A field that is added does not compile here until it has a row below.
  [[maybe_unused]] const auto& [name, radars, rig_file, beta_s, begin_s, end_s] = DriveRequest{};
  ExpectEachFieldIsValidated<DriveRequest>(
      {},
      {{"beta_s",
        [](auto& o, double v) { o.beta_s = v; },
        {.minus_one = "the bound of a radar's", .zero = "no coupling"}},
       {"begin_s", [](auto& o, double v) { o.begin_s = v; }, {.zero = "from the first scan on"}},
       {"end_s", [](auto& o, double v) { o.end_s = v; }, {.zero = "the first scan alone"}}});
}

TEST(NuScenesOptionsTest, EachFieldIsValidated) {
  [[maybe_unused]] const auto& [version, filter, max_can_bus_age] = NuScenesOptions{};
  ExpectEachFieldIsValidated<NuScenesOptions>(
      {},
      {{"max_can_bus_age",
        [](auto& o, double v) { o.max_can_bus_age = std::chrono::seconds(static_cast<int>(v)); },
        {.nan = kIsAnInteger, .zero = "samples of the very moment only"}}});
}

TEST(DatasetTest, AFormatIsFoundByItsName) {
  EXPECT_EQ(*DatasetFormatByName("nuscenes"), DatasetFormat::kNuScenes);
  EXPECT_EQ(*DatasetFormatByName("radarscenes"), DatasetFormat::kRadarScenes);
  const absl::Status third = DatasetFormatByName("kitti").status();
  EXPECT_EQ(third.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(third.message(),
            "dataset is 'kitti'; it must be one of nuscenes, radarscenes, rosbag, snail-radar, "
            "ntu4dradlm, msc-rad4r, hercules, zod");
}

TEST(DatasetTest, AFormatThatThereIsNotIsNotReadAsAnother) {
  const absl::Status status =
      ReadDrive({.format = static_cast<DatasetFormat>(99)}, {.name = "a"}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("format is 99"));
}

TEST(DatasetTest, ARequestThatMakesNoSenseIsRefusedBeforeReading) {
  const absl::Status status = ReadDrive({}, {.name = "a", .begin_s = -1.0}).status();
  EXPECT_THAT(std::string(status.message()), HasSubstr("begin_s is -1"));
}

TEST(BuildMapTest, AScanOfAnUnknownRadarIsAnError) {
  Drive drive{.name = "street", .rig = {.radars = {{.id = "front"}}}};
  drive.scans.push_back({.scan = {.radar_id = "rear"}});
  const absl::Status status = BuildMap(drive, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("radar 'rear'"));
}

}  // namespace
}  // namespace dcloc
