#include "client/datasets/nuscenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "tests/client/datasets/tiny_nuscenes.h"

namespace dcloc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

DriveRequest Scene1() { return {.name = "scene-0001", .radars = {}, .beta_s = std::nullopt}; }

absl::StatusOr<Drive> Read(const TinyNuScenes& tiny, const DriveRequest& request = Scene1(),
                           const NuScenesOptions& options = {}) {
  const TempFolder folder;
  tiny.WriteTo(folder);
  return ReadNuScenesDrive(folder.path(), request, options);
}

TEST(NuScenes, ReadsTheScansOfItsSceneByStamp) {
  const auto drive = Read(TinyNuScenes());
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ(drive->name, "scene-0001");
  EXPECT_EQ(drive->place, "tiny-town");
  ASSERT_EQ(drive->scans.size(), 4U);
  std::vector<std::string> radars;
  std::vector<std::int64_t> times_ms;
  for (const DriveScan& entry : drive->scans) {
    radars.push_back(entry.scan.radar_id);
    times_ms.push_back(entry.scan.stamp.time_since_epoch().count() / 1'000'000);
  }
  EXPECT_THAT(radars,
              ElementsAre("RADAR_FRONT", "RADAR_BACK_LEFT", "RADAR_FRONT", "RADAR_BACK_LEFT"));
  EXPECT_THAT(times_ms, ElementsAre(1000, 1040, 1080, 1120));
  EXPECT_NEAR(drive->scans[2].T_map_vehicle.translation_m.x(), 100.8, 1e-9);
  EXPECT_THAT(drive->scans[3].scan.range_m, IsEmpty());
}

TEST(NuScenes, TurnsTargetsIntoPolarColumns) {
  const auto drive = Read(TinyNuScenes());
  ASSERT_TRUE(drive.ok()) << drive.status();
  const Scan& scan = drive->scans[2].scan;
  ASSERT_EQ(scan.size(), 2U);
  EXPECT_FLOAT_EQ(scan.range_m[1], 5.0F);
  EXPECT_FLOAT_EQ(scan.azimuth_rad[1], std::atan2(4.0F, 3.0F));
  EXPECT_FLOAT_EQ(scan.range_rate_mps[0], -10.0F);
  EXPECT_FLOAT_EQ(scan.range_rate_mps[1], -6.0F);  // (3, 4) . (-10, 0) / 5
  EXPECT_FLOAT_EQ(scan.rcs_dbsm[1], 5.0F);
  EXPECT_THAT(scan.elevation_rad, IsEmpty());
}

TEST(NuScenes, TakesMountsFromCalibratedSensor) {
  const auto drive = Read(TinyNuScenes());
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_EQ(drive->rig.radars.size(), 2U);
  const RadarModel* back = drive->rig.Find("RADAR_BACK_LEFT");
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->T_vehicle_radar.translation_m, Eigen::Vector3d(-0.5, 0.6, 0.5));
  EXPECT_NEAR(std::abs(Yaw(back->T_vehicle_radar.rotation)), 3.14159265, 1e-6);
  EXPECT_EQ(back->beta_s, 0.0);
}

TEST(NuScenes, InterpolatesEgoVelocityFromTheBus) {
  const auto drive = Read(TinyNuScenes());
  ASSERT_TRUE(drive.ok()) << drive.status();
  const auto& velocity = drive->scans[0].scan.ego_velocity;  // halfway between samples 0 and 1
  ASSERT_TRUE(velocity.has_value());
  EXPECT_NEAR(velocity->linear_mps.x(), 10.05, 1e-9);
  EXPECT_NEAR(velocity->angular_radps.z(), 0.005, 1e-9);
}

TEST(NuScenes, HasNoEgoVelocityWithoutABusLog) {
  TinyNuScenes tiny;
  tiny.files.erase("can_bus/scene-0001_pose.json");
  const auto drive = Read(tiny);
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (const DriveScan& entry : drive->scans) EXPECT_FALSE(entry.scan.ego_velocity.has_value());
}

TEST(NuScenes, SaysThatABusLogIsOfAnotherClock) {
  TinyNuScenes tiny;
  EXPECT_TRUE(Read(tiny)->notes.empty());
  nlohmann::json bus = nlohmann::json::parse(tiny.files.at("can_bus/scene-0001_pose.json"));
  for (auto& sample : bus) sample["utime"] = sample["utime"].get<std::int64_t>() + 1'000'000'000;
  tiny.files["can_bus/scene-0001_pose.json"] = bus.dump();
  const auto drive = Read(tiny);
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_EQ(drive->notes.size(), 1U);
  EXPECT_NE(drive->notes[0].find("of one clock"), std::string::npos);
}

TEST(NuScenes, FiltersByTheDevicesCodes) {
  TinyNuScenes tiny;
  PcdPoint invalid{1.0F, 0.0F};
  invalid.invalid_state = 4;
  PcdPoint ambiguous{2.0F, 0.0F};
  ambiguous.ambig_state = 2;
  PcdPoint stopped{3.0F, 0.0F};
  stopped.dyn_prop = 7;
  PcdPoint moving{4.0F, 0.0F};
  moving.dyn_prop = 0;
  tiny.files["sweeps/RADAR_FRONT/1000000.pcd"] =
      PcdBytes({invalid, ambiguous, stopped, moving, {0.0F, 0.0F}, {5.0F, 0.0F}});

  const auto by_default = Read(tiny);
  ASSERT_TRUE(by_default.ok()) << by_default.status();
  EXPECT_THAT(by_default->scans[0].scan.range_m, ElementsAre(4.0F, 5.0F));

  NuScenesOptions all;
  all.filter = {{0, 4}, {2, 3}, {0, 1, 7}};
  const auto unfiltered = Read(tiny, Scene1(), all);
  ASSERT_TRUE(unfiltered.ok()) << unfiltered.status();
  EXPECT_THAT(unfiltered->scans[0].scan.range_m, ElementsAre(1.0F, 2.0F, 3.0F, 4.0F, 5.0F));
}

TEST(NuScenes, ChoosesRadarsAndOverridesBeta) {
  DriveRequest request = Scene1();
  request.radars = {"RADAR_FRONT"};
  request.beta_s = 0.04;
  const auto drive = Read(TinyNuScenes(), request);
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_EQ(drive->rig.radars.size(), 1U);
  EXPECT_EQ(drive->rig.radars[0].beta_s, 0.04);
  EXPECT_EQ(drive->scans.size(), 2U);
}

TEST(NuScenes, TakesTheRigFilesWordForTheRadars) {
  TinyNuScenes tiny;
  tiny.tables["dcloc_rig"] = {
      {"radars",
       {{{"id", "RADAR_FRONT"}, {"beta_s", 0.02}, {"has_elevation", true}, {"range_sigma_m", 0.05}},
        {{"id", "RADAR_BACK_LEFT"}, {"beta_s", -0.01}},
        {{"id", "RADAR_UNUSED"}, {"beta_s", 1e9}}}}};
  tiny.files["sweeps/RADAR_FRONT/1000000.pcd"] = PcdBytes({{3.0F, 4.0F, 5.0F, 0.6F, 0.8F}});
  const auto drive = Read(tiny);
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ(drive->rig.Find("RADAR_FRONT")->beta_s, 0.02);
  EXPECT_EQ(drive->rig.Find("RADAR_FRONT")->range_sigma_m, 0.05);
  EXPECT_EQ(drive->rig.Find("RADAR_BACK_LEFT")->beta_s, -0.01);
  const Scan& scan = drive->scans[0].scan;
  EXPECT_FLOAT_EQ(scan.range_m[0], std::sqrt(50.0F));
  EXPECT_FLOAT_EQ(scan.elevation_rad[0], std::atan2(5.0F, 5.0F));
  EXPECT_FLOAT_EQ(scan.range_rate_mps[0], 1.0F);

  DriveRequest request = Scene1();
  request.beta_s = 0.0;
  const auto overridden = Read(tiny, request);
  ASSERT_TRUE(overridden.ok()) << overridden.status();
  EXPECT_EQ(overridden->rig.Find("RADAR_FRONT")->beta_s, 0.0);
}

TEST(NuScenes, AsksForAVersionWhenThereAreSeveral) {
  const TempFolder folder;
  TinyNuScenes tiny;
  tiny.WriteTo(folder);
  tiny.version = "v1.0-other";
  tiny.WriteTo(folder);
  const auto ambiguous = ReadNuScenesDrive(folder.path(), Scene1());
  EXPECT_EQ(ambiguous.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ambiguous.status().message()), HasSubstr("v1.0-other, v1.0-tiny"));
  NuScenesOptions options;
  options.version = "v1.0-other";
  EXPECT_TRUE(ReadNuScenesDrive(folder.path(), Scene1(), options).ok());
  options.version = "v1.0-none";
  EXPECT_EQ(ReadNuScenesDrive(folder.path(), Scene1(), options).status().code(),
            absl::StatusCode::kNotFound);
}

TEST(NuScenes, SaysWhatThereIsInsteadOfAnUnknownName) {
  DriveRequest request = Scene1();
  request.name = "scene-9999";
  EXPECT_THAT(std::string(Read(TinyNuScenes(), request).status().message()),
              HasSubstr("no scene \"scene-9999\"; the scenes are scene-0001, scene-0002"));
  request = Scene1();
  request.radars = {"RADAR_TOP"};
  EXPECT_THAT(std::string(Read(TinyNuScenes(), request).status().message()),
              HasSubstr("its radars are RADAR_BACK_LEFT, RADAR_FRONT"));
  const TempFolder empty;
  EXPECT_EQ(ReadNuScenesDrive(empty.path(), Scene1()).status().code(), absl::StatusCode::kNotFound);
}

struct NuScenesFault {
  const char* name;
  std::function<void(TinyNuScenes&)> inflict;
  std::vector<std::string> said;
};

class BrokenNuScenes : public ::testing::TestWithParam<NuScenesFault> {};

TEST_P(BrokenNuScenes, NamesTheFileAndTheFault) {
  TinyNuScenes tiny;
  GetParam().inflict(tiny);
  const auto drive = Read(tiny);
  ASSERT_FALSE(drive.ok());
  for (const std::string& words : GetParam().said) {
    EXPECT_THAT(std::string(drive.status().message()), HasSubstr(words));
  }
}

std::vector<NuScenesFault> NuScenesFaults() {
  return {
      {"NoSceneTable", [](auto& t) { t.tables.erase("scene"); }, {"scene.json", "no such file"}},
      {"NoLog", [](auto& t) { t.tables["log"][0]["token"] = "x"; }, {"log.json", "no log l1"}},
      {"DanglingSensor",
       [](auto& t) { t.tables["calibrated_sensor"][0]["sensor_token"] = "x"; },
       {"calibrated_sensor.json", "record 0", "\"sensor_token\" x is not in sensor.json"}},
      {"SensorWithoutModality",
       [](auto& t) { t.tables["sensor"][1].erase("modality"); },
       {"sensor.json", "record 1", "\"modality\" is missing"}},
      {"MountNoQuaternion",
       [](auto& t) {
         t.tables["calibrated_sensor"][1]["rotation"] = {2.0, 0.0, 0.0, 0.0};
       },
       {"calibrated_sensor.json", "record 1", "norm 2"}},
      {"SceneWithoutSamples",
       [](auto& t) { t.tables["sample"][0]["scene_token"] = "x"; },
       {"sample.json", "no sample of scene s1"}},
      {"SceneWithoutSweeps",
       [](auto& t) { t.tables["sample"][0]["token"] = "x"; },
       {"sample_data.json", "no radar sweep of scene scene-0001"}},
      {"DanglingCalibration",
       [](auto& t) { t.tables["sample_data"][0]["calibrated_sensor_token"] = "x"; },
       {"sample_data.json", "record 0",
        "\"calibrated_sensor_token\" x is not in calibrated_sensor"}},
      {"TimestampIsText",
       [](auto& t) { t.tables["sample_data"][1]["timestamp"] = "soon"; },
       {"sample_data.json", "record 1", "\"timestamp\" must be an integer"}},
      {"DanglingPose",
       [](auto& t) { t.tables["sample_data"][1]["ego_pose_token"] = "x"; },
       {"ego_pose.json", "no pose x", "sweeps/RADAR_FRONT/1080000.pcd"}},
      {"PoseWithoutTranslation",
       [](auto& t) { t.tables["ego_pose"][2].erase("translation"); },
       {"ego_pose.json", "record 2", "\"translation\" is missing"}},
      {"TwoMountsOfOneRadar",
       [](auto& t) {
         t.tables["calibrated_sensor"].push_back(t.tables["calibrated_sensor"][0]);
         t.tables["calibrated_sensor"].back()["token"] = "cf2";
         t.tables["calibrated_sensor"].back()["translation"] = {0.0, 0.0, 0.0};
         t.tables["sample_data"][1]["calibrated_sensor_token"] = "cf2";
       },
       {"sample_data.json", "RADAR_FRONT has two different calibrated sensors"}},
      {"SweepMissing",
       [](auto& t) { t.files.erase("sweeps/RADAR_FRONT/1080000.pcd"); },
       {"sweeps/RADAR_FRONT/1080000.pcd", "no such file"}},
      {"SweepTruncated",
       [](auto& t) { t.files["sweeps/RADAR_FRONT/1080000.pcd"].pop_back(); },
       {"sweeps/RADAR_FRONT/1080000.pcd", "truncated"}},
      {"SweepOutOfRange",
       [](auto& t) {
         t.files["sweeps/RADAR_FRONT/1080000.pcd"] = PcdBytes({{1e30F, 0.0F}});
       },
       {"sweeps/RADAR_FRONT/1080000.pcd", "range_m"}},
      {"TwoSweepsOfOneStamp",
       [](auto& t) { t.tables["sample_data"][1]["timestamp"] = 1000000; },
       {"v1.0-tiny", "RADAR_FRONT has two scans of one stamp"}},
      {"BusLogBroken",
       [](auto& t) { t.files["can_bus/scene-0001_pose.json"] = "[{"; },
       {"can_bus/scene-0001_pose.json", "not valid JSON"}},
      {"RigFileWithoutARadar",
       [](auto& t) {
         t.tables["dcloc_rig"] = {{"radars", nlohmann::json::array()}};
       },
       {"dcloc_rig.json", "does not list radar RADAR_BACK_LEFT"}},
      {"RigFileIsNoObject",
       [](auto& t) { t.tables["dcloc_rig"] = nlohmann::json::array(); },
       {"dcloc_rig.json", "array \"radars\""}},
      {"RigFileUnknownKey",
       [](auto& t) {
         t.tables["dcloc_rig"] = {
             {"radars", {{{"id", "RADAR_FRONT"}}, {{"id", "RADAR_BACK_LEFT"}, {"betas", 1}}}}};
       },
       {"dcloc_rig.json", "radar RADAR_BACK_LEFT: unknown key \"betas\""}},
      {"RigFileBadSigma",
       [](auto& t) {
         t.tables["dcloc_rig"] = {
             {"radars",
              {{{"id", "RADAR_FRONT"}}, {{"id", "RADAR_BACK_LEFT"}, {"range_sigma_m", -1.0}}}}};
       },
       {"dcloc_rig.json", "range_sigma_m"}},
  };
}

INSTANTIATE_TEST_SUITE_P(Each, BrokenNuScenes, ::testing::ValuesIn(NuScenesFaults()),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace dcloc
