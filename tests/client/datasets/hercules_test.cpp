// HeRCULES: sequences written from a simulated drive are localized; what is broken is named.
#include "client/datasets/hercules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/client/datasets/body_frame.h"
#include "tests/client/datasets/hercules_writer.h"
#include "tests/client/datasets/localized_set.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const TwoPasses& HerculesPasses() {
  static const TwoPasses passes = SimulateTwoPasses(/*seed=*/22);
  return passes;
}

class HerculesTest : public ::testing::Test {
 protected:
  HerculesTest() { WriteHercules(HerculesPasses().live, folder_.path(), "Mountain/Day2"); }

  absl::Status Status() const {
    return ReadHerculesDrive(folder_.path(), {.name = "Mountain/Day2"}).status();
  }
  std::string Error() const { return std::string(Status().message()); }
  fs::path Sequence() const { return folder_.path() / "Mountain/Day2"; }
  fs::path FirstScan() const {
    const auto ns = HerculesPasses().live.scans[0].scan.stamp.time_since_epoch().count();
    return Sequence() / "Radar/Continental" / absl::StrCat(ns, ".bin");
  }

  TempFolder folder_;
};

TEST_F(HerculesTest, IsLocalized) {
  WriteHercules(HerculesPasses().map, folder_.path(), "Mountain/Day1");
  const Dataset dataset{DatasetFormat::kHercules, folder_.path(), ""};
  EXPECT_EQ(*DetectFormat(folder_.path()), DatasetFormat::kHercules);
  EXPECT_THAT(*DriveNames(dataset), ElementsAre("Mountain/Day1", "Mountain/Day2"));
  const Drive map_drive = ReadDriveOf(dataset, "Mountain/Day1");
  const Drive live_drive = ReadDriveOf(dataset, "Mountain/Day2");
  ExpectPosesOf(live_drive, HerculesPasses().live, Pose3(), 1e-6, 1e-6);
  EXPECT_EQ(live_drive.velocity_source, VelocitySource::kDoppler);
  const auto radar_map = MapOfDrive(map_drive);
  const std::vector<Localization> answers = LocalizeIn(radar_map, live_drive);
  ExpectLocalized(answers, live_drive, 0.15);
  ExpectTheSameAsABag(radar_map, live_drive, answers);
}

TEST_F(HerculesTest, AScanThatIsCutOffIsNamed) {
  fs::resize_file(FirstScan(), 29 * 3 + 7);
  EXPECT_EQ(Status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(Error(), AllOf(HasSubstr(FirstScan().string()), HasSubstr("has 94 bytes"),
                             HasSubstr("record 3 is cut off")));
}

TEST_F(HerculesTest, AScanThatIsListedAndMissingIsNamed) {
  fs::remove(FirstScan());
  EXPECT_EQ(Status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(Error(), AllOf(HasSubstr(FirstScan().string()), HasSubstr("data_stamp.csv, line 2")));
}

TEST_F(HerculesTest, AMissingFolderIsNamed) {
  fs::remove_all(Sequence() / "Radar");
  EXPECT_EQ(Status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(Error(), HasSubstr("there is no folder Radar/Continental"));
}

TEST_F(HerculesTest, AMissingCalibrationIsNamed) {
  fs::remove(Sequence() / "Calibration/IMU_LiDAR.txt");
  EXPECT_EQ(Status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(Error(), HasSubstr("Calibration/IMU_LiDAR.txt: there is no such file"));
}

TEST_F(HerculesTest, ACalibrationThatTurnsNothingIsNamed) {
  folder_.Write("Mountain/Day2/Calibration/IMU_LiDAR.txt",
                "Tr_lidar_to_imu: 2 0 0 0 0 1 0 0 0 0 1 0");
  EXPECT_THAT(Error(), HasSubstr("Tr_lidar_to_imu must be three rows of a rotation"));
}

TEST_F(HerculesTest, PosesThatAreCutOffOrGoBackAreNamed) {
  const std::string row = "1700000000000000000 1 2 3 0 0 0 1\n";
  folder_.Write("Mountain/Day2/PR_GT/Continental_gt.txt", row + "1700000000100000000 1 2");
  EXPECT_THAT(Error(),
              HasSubstr("Continental_gt.txt: line 2: has 3 values; at least 8 are needed"));
  folder_.Write("Mountain/Day2/PR_GT/Continental_gt.txt", row + row);
  EXPECT_THAT(Error(), HasSubstr("line 2: the stamp is 1700000000000000000 ns; it must be after"));
  folder_.Write("Mountain/Day2/PR_GT/Continental_gt.txt", "1700000000000000000 1 nan 3 0 0 0 1\n");
  EXPECT_THAT(Error(), HasSubstr("line 1: y is 'nan'"));
}

TEST_F(HerculesTest, AFileThatIsNamedByNoStampIsNamed) {
  folder_.Write("Mountain/Day2/Radar/Continental/first.bin", "");
  EXPECT_THAT(Error(), HasSubstr("the stamp is 'first'"));
}

}  // namespace
}  // namespace dcloc
