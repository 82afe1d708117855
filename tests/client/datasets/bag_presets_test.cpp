// Public data sets of bags: written from a simulated drive, read by their names, and localized in.
#include "client/datasets/bag_presets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "client/datasets/check/mapping_correction.h"
#include "client/datasets/check/range_rate_check.h"
#include "tests/client/datasets/bag_set_writer.h"
#include "tests/client/datasets/body_frame.h"
#include "tests/client/datasets/localized_set.h"

namespace dcloc {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const TwoPasses& BagPasses() {
  static const TwoPasses passes = SimulateTwoPasses(/*seed=*/21);
  return passes;
}

class BagPresetsTest : public ::testing::Test {
 protected:
  void Write(BagSet set, const std::string& map, const std::string& live) const {
    WriteBagSet(set, BagPasses().map, folder_.path(), map);
    WriteBagSet(set, BagPasses().live, folder_.path(), live);
  }
  void ExpectLocalizedAs(DatasetFormat format, const std::string& map, const std::string& live,
                         const Pose3& T_vehicle_body) const {
    const Dataset dataset{format, folder_.path(), ""};
    EXPECT_EQ(DetectFormat(folder_.path()).value(), format);
    const Drive map_drive = ReadDriveOf(dataset, map);
    const Drive live_drive = ReadDriveOf(dataset, live);
    ExpectPosesOf(live_drive, BagPasses().live, T_vehicle_body, 1e-6, 1e-6);
    EXPECT_TRUE(live_drive.rig.radars.at(0).has_elevation);
    const auto radar_map = MapOfDrive(map_drive);
    const std::vector<Localization> answers = LocalizeIn(radar_map, live_drive);
    ExpectLocalized(answers, live_drive, 0.15);
    ExpectTheSameAsABag(radar_map, live_drive, answers);
  }

  TempFolder folder_;
};

TEST_F(BagPresetsTest, SnailRadarIsLocalized) {
  Write(BagSet::kSnailRadar, "20240123/data2", "20240123/data3");
  const Dataset dataset{DatasetFormat::kSnailRadar, folder_.path(), ""};
  EXPECT_THAT(*DriveNames(dataset), ElementsAre("20240123/data2", "20240123/data3"));
  ExpectLocalizedAs(DatasetFormat::kSnailRadar, "20240123/data2", "20240123/data3",
                    BodyOnVehicle(BagPasses().live, MountInSet(BagSet::kSnailRadar)));
  EXPECT_THAT(ReadDriveOf(dataset, "20240123/data2").notes, IsEmpty());
}

TEST_F(BagPresetsTest, Ntu4dRadLmIsLocalized) {
  Write(BagSet::kNtu4dRadLm, "loop2/loop2_2022-06-03_0", "loop3/loop3_2022-06-03_0");
  folder_.Write("loop2/gt_odom.bag", "not a drive");
  const Dataset dataset{DatasetFormat::kNtu4dRadLm, folder_.path(), ""};
  EXPECT_THAT(*DriveNames(dataset),
              ElementsAre("loop2/loop2_2022-06-03_0", "loop3/loop3_2022-06-03_0"));
  ExpectLocalizedAs(DatasetFormat::kNtu4dRadLm, "loop2/loop2_2022-06-03_0",
                    "loop3/loop3_2022-06-03_0",
                    BodyOnVehicle(BagPasses().live, MountInSet(BagSet::kNtu4dRadLm)));
  // The radar is level here, and so the lidar on which it sits is not.
  EXPECT_THAT(ReadDriveOf(dataset, "loop2/loop2_2022-06-03_0").notes,
              Contains(HasSubstr("it drives 2.6 degrees out of its xy plane")));
}

TEST_F(BagPresetsTest, MscRad4rIsLocalizedOnceTheMountIsSaid) {
  Write(BagSet::kMscRad4r, "URBAN_A0", "URBAN_A1");
  const auto bag = FindBagOfSet(folder_.path(), "URBAN_A0");
  ASSERT_TRUE(bag.ok()) << bag.status();
  auto mapping = MappingOfSet(BagSet::kMscRad4r, folder_.path(), *bag);
  ASSERT_TRUE(mapping.ok()) << mapping.status();
  EXPECT_EQ(mapping->reference_topic, "/fix");
  mapping->radars.at(0).T_vehicle_radar = BagPasses().map.rig.radars.at(0).T_vehicle_radar;
  folder_.Write("dcloc_bag.json", BagMappingJson(*mapping).dump());
  const Dataset dataset{DatasetFormat::kMscRad4r, folder_.path(), ""};
  EXPECT_EQ(*DetectFormat(folder_.path()), DatasetFormat::kMscRad4r);
  const Drive map_drive = ReadDriveOf(dataset, "URBAN_A0");
  const Drive live_drive = ReadDriveOf(dataset, "URBAN_A1");
  EXPECT_THAT(live_drive.notes, Contains(HasSubstr("latitude 36.25, longitude 127.25")));
  ExpectPosesOf(live_drive, BagPasses().live, Pose3(), 0.01, 0.03);
  const auto radar_map = MapOfDrive(map_drive);
  const std::vector<Localization> answers = LocalizeIn(radar_map, live_drive);
  ExpectLocalized(answers, live_drive, 0.2);
  ExpectTheSameAsABag(radar_map, live_drive, answers);
}

TEST_F(BagPresetsTest, ADriveThatIsNotThereIsNamedWithThoseThatAre) {
  Write(BagSet::kSnailRadar, "20240123/data2", "20240123/data3");
  const absl::Status status =
      ReadBagSetDrive(BagSet::kSnailRadar, folder_.path(), {.name = "20240123/data4"}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("\"20240123/data4\"; the bags are 20240123/data2, 20240123/data3"));
}

TEST_F(BagPresetsTest, PosesThatGoBackAreNamed) {
  WriteBagSet(BagSet::kNtu4dRadLm, BagPasses().live, folder_.path(), "cp/cp_0");
  folder_.Write(
      "cp/gt_odom.txt",
      "1700000000.5 0 0 0 0 0 0 1\n1700000001.5 1 0 0 0 0 0 1\n1700000001 2 0 0 0 0 0 1\n");
  const absl::Status status =
      ReadBagSetDrive(BagSet::kNtu4dRadLm, folder_.path(), {.name = "cp/cp_0"}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), HasSubstr("gt_odom.txt: line 3: the stamp is"));
}

TEST_F(BagPresetsTest, WithoutPosesADriveStillIsOne) {
  WriteBagSet(BagSet::kSnailRadar, BagPasses().live, folder_.path(), "20240123/data3");
  std::filesystem::remove_all(folder_.path() / "ref_trajs_all");
  const auto drive =
      ReadBagSetDrive(BagSet::kSnailRadar, folder_.path(), {.name = "20240123/data3"});
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ(drive->pose_source, PoseSource::kNone);
}

TEST_F(BagPresetsTest, OfABagThatIsCutOffTheWholePartIsRead) {
  WriteBagSet(BagSet::kNtu4dRadLm, BagPasses().live, folder_.path(), "cp/cp_0");
  const std::filesystem::path bag = folder_.path() / "cp/cp_0.bag";
  std::filesystem::resize_file(bag, std::filesystem::file_size(bag) / 2);
  const auto drive = ReadBagSetDrive(BagSet::kNtu4dRadLm, folder_.path(), {.name = "cp/cp_0"});
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_LT(drive->scans.size(), BagPasses().live.scans.size());
  EXPECT_THAT(drive->notes, Contains(HasSubstr("cut off at byte")));
}

TEST_F(BagPresetsTest, WhatARadarCountsTheOtherWayRoundIsFoundByTheData) {
  Drive turned = BagPasses().live;
  for (DriveScan& entry : turned.scans) {
    for (float& rate : entry.scan.range_rate_mps) rate = -rate;
  }
  WriteBagSet(BagSet::kSnailRadar, turned, folder_.path(), "20240123/data3");
  const auto bag = FindBagOfSet(folder_.path(), "20240123/data3");
  const auto mapping = MappingOfSet(BagSet::kSnailRadar, folder_.path(), *bag);
  ASSERT_TRUE(mapping.ok()) << mapping.status();
  const auto drive =
      ReadBagSetDrive(BagSet::kSnailRadar, folder_.path(), {.name = "20240123/data3"});
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_TRUE(
      CorrectedMapping(*mapping, CheckRangeRates(*drive)).radars.at(0).range_rate_is_towards);
}

}  // namespace
}  // namespace dcloc
