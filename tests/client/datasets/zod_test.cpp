// ZOD: drives written from a simulated one are localized; what is broken is named.
#include "client/datasets/zod.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "client/rosbag/bag_bytes.h"
#include "tests/client/datasets/body_frame.h"
#include "tests/client/datasets/localized_set.h"
#include "tests/client/datasets/zod_writer.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const TwoPasses& ZodPasses() {
  static const TwoPasses passes = SimulateTwoPasses(/*seed=*/23);
  return passes;
}

class ZodTest : public ::testing::Test {
 protected:
  ZodTest() {
    WriteZod({{"000001", &ZodPasses().map, {0.0, 0.0, 0.0}},
              {"000002", &ZodPasses().live, {100.0, 50.0, 0.0}}},
             folder_.path());
  }
  absl::Status Status() const { return ReadZodDrive(folder_.path(), {.name = "000002"}).status(); }
  std::string Error() const { return std::string(Status().message()); }
  void WriteRadar(const std::string& bytes) const {
    folder_.Write("drives/000002/radar_front/radar.npy", bytes);
  }
  /// Two scans of one target each, at these stamps.
  static std::string TwoScans(const char* rate_type, std::int64_t first_ns, std::int64_t second_ns,
                              bool fortran_order = false) {
    std::string rows;
    for (std::uint32_t i = 0; i < 2; ++i) {
      rosbag::AppendNumber(rows, i);
      rosbag::AppendNumber(rows, i == 0 ? first_ns : second_ns);
      for (int field = 0; field < 4; ++field) rosbag::AppendNumber(rows, 1.0F);
    }
    return NpyBytes({{"scan_index", "<u4"},
                     {"timestamp", "<i8"},
                     {"radar_range", "<f4"},
                     {"azimuth_angle", "<f4"},
                     {"elevation_angle", "<f4"},
                     {"range_rate", rate_type}},
                    2, rows, fortran_order);
  }

  TempFolder folder_;
};

TEST_F(ZodTest, IsLocalized) {
  const Dataset dataset{DatasetFormat::kZod, folder_.path(), ""};
  EXPECT_EQ(*DetectFormat(folder_.path()), DatasetFormat::kZod);
  EXPECT_THAT(*DriveNames(dataset), ElementsAre("000001", "000002"));
  const Drive map_drive = ReadDriveOf(dataset, "000001");
  const Drive live_drive = ReadDriveOf(dataset, "000002");
  EXPECT_THAT(live_drive.notes, Contains(HasSubstr("latitude 57.75, longitude 12.00")));
  // The axes of two origins 100 m apart differ by the meridians' convergence.
  ExpectPosesOf(live_drive, ZodPasses().live, Pose3(), 0.005, 1e-4);
  // Turn rates counted clockwise are turned back.
  double product = 0.0;
  for (std::size_t i = 0; i < live_drive.scans.size(); ++i) {
    product += live_drive.scans[i].scan.ego_velocity->angular_radps.z() *
               ZodPasses().live.scans[i].scan.ego_velocity->angular_radps.z();
  }
  EXPECT_GT(product, 0.0);
  const auto radar_map = MapOfDrive(map_drive);
  const std::vector<Localization> answers = LocalizeIn(radar_map, live_drive);
  ExpectLocalized(answers, live_drive, 0.15);
  ExpectTheSameAsABag(radar_map, live_drive, answers);
}

TEST_F(ZodTest, ATableThatIsCutOffIsNamed) {
  const fs::path path = folder_.path() / "drives/000002/radar_front/radar.npy";
  fs::resize_file(path, fs::file_size(path) - 5);
  EXPECT_EQ(Status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(Error(),
              AllOf(HasSubstr(path.string()), HasSubstr("rows of 35 bytes are announced")));
  fs::resize_file(path, 40);
  EXPECT_THAT(Error(), HasSubstr("the file ends after 30 of them"));
  fs::resize_file(path, 3);
  EXPECT_THAT(Error(), HasSubstr("is no NumPy file"));
}

TEST_F(ZodTest, AColumnOfAnotherTypeIsNamed) {
  WriteRadar(TwoScans("<i4", 1, 2));
  EXPECT_THAT(Error(), HasSubstr("field \"range_rate\" is of type '<i4'; it must be '<f4'"));
}

TEST_F(ZodTest, FortranOrderIsNamed) {
  WriteRadar(TwoScans("<f4", 1, 2, /*fortran_order=*/true));
  EXPECT_THAT(Error(), HasSubstr("fortran_order is not False"));
}

TEST_F(ZodTest, ScansThatGoBackAreNamed) {
  WriteRadar(TwoScans("<f4", 1'700'000'000'000'000'002, 1'700'000'000'000'000'001));
  EXPECT_EQ(Status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(Error(), HasSubstr("field \"timestamp\" of row 1 is 1700000000000000001; a scan must "
                                 "be after the one before"));
}

TEST_F(ZodTest, WhatIsMissingIsNamed) {
  fs::remove(folder_.path() / "drives/000002/calibration.json");
  EXPECT_EQ(Status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(Error(), HasSubstr("calibration.json: there is no such file"));
  folder_.Write("drives/000002/calibration.json", R"({"FC": {"lidar_extrinsics": []}})");
  EXPECT_THAT(Error(), HasSubstr("has no FC: radar_extrinsics"));
  const absl::Status other = ReadZodDrive(folder_.path(), {.name = "7"}).status();
  EXPECT_THAT(std::string(other.message()), HasSubstr("the drives are 000001, 000002"));
}

TEST_F(ZodTest, MotionThatIsBrokenIsNamed) {
  const auto write = [&](const std::string& text) {
    folder_.Write("drives/000002/ego_motion.json", text);
  };
  write(R"({"timestamps": [1.0, 2.0], "poses": [[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]],
            "velocities": [], "angular_rates": [], "origin_lat_lon": [57.7, 12]})");
  EXPECT_THAT(Error(), HasSubstr("\"poses\" has 1 rows; \"timestamps\" has 2"));
  write(R"({"timestamps": [1.0], "poses": [[[1,0,0,0],[0,1,0],[0,0,1,0],[0,0,0,1]]]})");
  EXPECT_THAT(Error(), HasSubstr("\"poses\": row 1 must have 4 numbers"));
  write(R"({"timestamps": [1.0], "poses": [)");
  EXPECT_THAT(Error(), HasSubstr("is not valid JSON"));
}

}  // namespace
}  // namespace dcloc
