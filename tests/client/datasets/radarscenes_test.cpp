#include "client/datasets/radarscenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>

#include "tests/client/datasets/tiny_radarscenes.h"

namespace dcloc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

DriveRequest Sequence7() { return {.name = "sequence_7", .radars = {}, .beta_s = std::nullopt}; }

absl::StatusOr<Drive> Read(const TinyRadarScenes& tiny, const DriveRequest& request = Sequence7()) {
  const TempFolder folder;
  tiny.WriteTo(folder);
  return ReadRadarScenesDrive(folder.path(), request);
}

TEST(RadarScenes, ReadsScansMountsAndOdometry) {
  const auto drive = Read(TinyRadarScenes());
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ(drive->name, "sequence_7");
  ASSERT_EQ(drive->scans.size(), 4U);
  const DriveScan& first = drive->scans[0];
  EXPECT_EQ(first.scan.radar_id, "radar_2");
  EXPECT_THAT(first.scan.range_m, ElementsAre(20.0F, 10.0F));
  EXPECT_THAT(first.scan.range_rate_mps, ElementsAre(-10.0F, 2.0F));
  EXPECT_THAT(first.scan.azimuth_rad, ElementsAre(0.0F, 0.5F));
  EXPECT_NEAR(first.T_map_vehicle.translation_m.x(), 5.1, 1e-6);
  ASSERT_TRUE(first.scan.ego_velocity.has_value());
  EXPECT_NEAR(first.scan.ego_velocity->linear_mps.x(), 10.5, 1e-6);
  EXPECT_NEAR(first.scan.ego_velocity->angular_radps.z(), 0.1, 1e-6);
  EXPECT_NEAR(drive->rig.Find("radar_1")->T_vehicle_radar.translation_m.y(), -0.8, 1e-12);
  EXPECT_NEAR(Yaw(drive->rig.Find("radar_1")->T_vehicle_radar.rotation), -1.5, 1e-12);
}

TEST(RadarScenes, ExtrapolatesShortlyBeyondTheOdometrysEnd) {
  const auto drive = Read(TinyRadarScenes());
  ASSERT_TRUE(drive.ok()) << drive.status();
  // 130 ms after the last row, which drives at 12 m/s.
  EXPECT_NEAR(drive->scans[3].T_map_vehicle.translation_m.x(), 6.2 + 12.0 * 0.13, 1e-5);
}

TEST(RadarScenes, InterpolatesHeadingTheShortWayRound) {
  TinyRadarScenes tiny;
  tiny.odometry[0].yaw_seq = 3.1F;
  tiny.odometry[1].yaw_seq = -3.1F;
  const auto drive = Read(tiny);
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_NEAR(std::abs(Yaw(drive->scans[0].T_map_vehicle.rotation)), 3.14159265, 1e-5);
}

TEST(RadarScenes, AcceptsNumbersForNames) {
  DriveRequest request;
  request.name = "7";
  request.radars = {"2"};
  request.beta_s = -0.02;
  const auto drive = Read(TinyRadarScenes(), request);
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_EQ(drive->rig.radars.size(), 1U);
  EXPECT_EQ(drive->rig.radars[0].id, "radar_2");
  EXPECT_EQ(drive->rig.radars[0].beta_s, -0.02);
  EXPECT_EQ(drive->scans.size(), 2U);
}

TEST(RadarScenes, LeavesOutTargetsThatAreNotFinite) {
  TinyRadarScenes tiny;
  tiny.targets[1].vr = std::numeric_limits<float>::quiet_NaN();
  const auto drive = Read(tiny);
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_THAT(drive->scans[0].scan.range_m, ElementsAre(20.0F));
}

TEST(RadarScenes, SaysWhatThereIsInsteadOfAnUnknownName) {
  DriveRequest request = Sequence7();
  request.name = "8";
  EXPECT_THAT(std::string(Read(TinyRadarScenes(), request).status().message()),
              HasSubstr("no sequence \"sequence_8\"; the sequences are sequence_7"));
  request = Sequence7();
  request.radars = {"5"};
  EXPECT_THAT(std::string(Read(TinyRadarScenes(), request).status().message()),
              HasSubstr("no radar \"radar_5\"; its radars are radar_1, radar_2"));
  request.radars = {"2", "radar_2"};
  EXPECT_THAT(std::string(Read(TinyRadarScenes(), request).status().message()),
              HasSubstr("named twice"));
}

TEST(RadarScenes, RefusesFilesThatAreNoHdf5) {
  const TempFolder folder;
  TinyRadarScenes().WriteTo(folder);
  const auto path = folder.path() / "data/sequence_7/radar_data.h5";
  const auto fault = [&] {
    return std::string(ReadRadarScenesDrive(folder.path(), Sequence7()).status().message());
  };
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 100);
  EXPECT_THAT(fault(), AllOf(HasSubstr("radar_data.h5"), HasSubstr("truncated")));
  folder.Write("data/sequence_7/radar_data.h5", "no HDF5 at all");
  EXPECT_THAT(fault(), AllOf(HasSubstr("radar_data.h5"), HasSubstr("no readable HDF5 file")));
  std::filesystem::remove(path);
  EXPECT_THAT(fault(), AllOf(HasSubstr("radar_data.h5"), HasSubstr("no such file")));
}

struct RadarScenesFault {
  const char* name;
  std::function<void(TinyRadarScenes&)> inflict;
  std::vector<std::string> said;
};

class BrokenRadarScenes : public ::testing::TestWithParam<RadarScenesFault> {};

TEST_P(BrokenRadarScenes, NamesTheFileAndTheFault) {
  TinyRadarScenes tiny;
  GetParam().inflict(tiny);
  const auto drive = Read(tiny);
  ASSERT_FALSE(drive.ok());
  EXPECT_EQ(drive.status().code(), absl::StatusCode::kDataLoss);
  for (const std::string& words : GetParam().said) {
    EXPECT_THAT(std::string(drive.status().message()), HasSubstr(words));
  }
}

std::vector<RadarScenesFault> RadarScenesFaults() {
  return {
      {"NoTable",
       [](auto& t) { t.target_table = "radar"; },
       {"radar_data.h5", "no data set \"radar_data\""}},
      {"NoColumn",
       [](auto& t) { t.range_column = "range"; },
       {"radar_data.h5", "no column \"range_sc\""}},
      {"ColumnOfText",
       [](auto& t) { t.range_is_text = true; },
       {"radar_data.h5", "\"range_sc\" must hold floating-point"}},
      {"NoOdometry",
       [](auto& t) { t.odometry.clear(); },
       {"radar_data.h5", "\"odometry\" is empty"}},
      {"OdometryBackwards",
       [](auto& t) { t.odometry[2].timestamp = 1000; },
       {"radar_data.h5", "\"odometry\" row 2 is not after"}},
      {"OdometryTooShort",
       [](auto& t) {
         t.odometry.resize(1);
         t.odometry[0].timestamp = 980000;
       },
       {"radar_data.h5", "nothing within 0.25 s"}},
      {"OdometryNotFinite",
       [](auto& t) { t.odometry[1].vx = std::numeric_limits<float>::infinity(); },
       {"sequence_7", "ego-velocity"}},
      {"OtherSensorInRows",
       [](auto& t) { t.targets[1].sensor_id = 1; },
       {"radar_data.h5", "row 1", "sensor 1", "scenes.json says sensor 2"}},
      {"OtherTimeInRows",
       [](auto& t) { t.targets[1].timestamp = 5; },
       {"radar_data.h5", "row 1", "at 5 us"}},
      {"TooFewRows",
       [](auto& t) { t.targets.pop_back(); },
       {"radar_data.h5", "ends at row 5 of 4"}},
      {"RangeOutOfBounds",
       [](auto& t) { t.targets[0].range_sc = 1e20F; },
       {"radar_data.h5", "scene at 1000000 us", "range_m"}},
      {"NoScenes", [](auto& t) { t.scenes.erase("scenes"); }, {"scenes.json", "object \"scenes\""}},
      {"SceneWithoutIndices",
       [](auto& t) { t.scenes["scenes"]["1030000"].erase("radar_indices"); },
       {"scenes.json", "scene 1030000", "\"radar_indices\" must be two row numbers"}},
      {"IndicesBackwards",
       [](auto& t) {
         t.scenes["scenes"]["1030000"]["radar_indices"] = {3, 2};
       },
       {"scenes.json", "scene 1030000", "run backwards"}},
      {"IndicesNegative",
       [](auto& t) {
         t.scenes["scenes"]["1030000"]["radar_indices"] = {-1, 2};
       },
       {"scenes.json", "\"radar_indices\" must be two row numbers"}},
      {"SceneKeyIsNoTime",
       [](auto& t) { t.scenes["scenes"]["noon"] = t.scenes["scenes"]["1030000"]; },
       {"scenes.json", "scene noon", "time in microseconds"}},
      {"ScenesAreEmpty",
       [](auto& t) { t.scenes["scenes"] = nlohmann::json::object(); },
       {"scenes.json", "no scene of its radars"}},
      {"MountWithoutYaw",
       [](auto& t) { t.sensors["radar_2"].erase("yaw"); },
       {"sensors.json", "radar_2", "\"yaw\" must be a number"}},
      {"NoRadars",
       [](auto& t) {
         t.sensors = {{"camera", 1}};
       },
       {"sensors.json", "lists no radar"}},
  };
}

INSTANTIATE_TEST_SUITE_P(Each, BrokenRadarScenes, ::testing::ValuesIn(RadarScenesFaults()),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace dcloc
