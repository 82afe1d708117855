// On the real recordings, where DCLOC_DATA names a folder that holds them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "client/datasets/dataset.h"

namespace dcloc {
namespace {

class Recordings : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* root = std::getenv("DCLOC_DATA");
    if (root == nullptr || !std::filesystem::exists(root)) {
      GTEST_SKIP() << "DCLOC_DATA names no folder with nuscenes_dev and radarscenes_dev";
    }
    nuscenes_ = {DatasetFormat::kNuScenes, std::filesystem::path(root) / "nuscenes_dev", ""};
    radarscenes_ = {DatasetFormat::kRadarScenes, std::filesystem::path(root) / "radarscenes_dev",
                    ""};
  }

  static Drive Read(const Dataset& dataset, const std::string& name) {
    DriveRequest request;
    request.name = name;
    auto drive = ReadDrive(dataset, request);
    EXPECT_TRUE(drive.ok()) << drive.status();
    return drive.ok() ? *std::move(drive) : Drive{};
  }

  Dataset nuscenes_;
  Dataset radarscenes_;
};

std::map<std::string, int> ScansPerRadar(const Drive& drive) {
  std::map<std::string, int> counts;
  for (const DriveScan& entry : drive.scans) ++counts[entry.scan.radar_id];
  return counts;
}

// Share of all targets whose range rate is what standing still would give, -u . v, by radar.
std::map<std::string, double> StaticShare(const Drive& drive, double gate_mps) {
  std::map<std::string, std::pair<double, double>> counts;
  for (const DriveScan& entry : drive.scans) {
    const Scan& scan = entry.scan;
    const Pose3& T_vehicle_radar = drive.rig.Find(scan.radar_id)->T_vehicle_radar;
    const EgoVelocity& ego = scan.ego_velocity.value();
    const Eigen::Vector3d v_radar =
        T_vehicle_radar.Rotation().transpose() *
        (ego.linear_mps + ego.angular_radps.cross(T_vehicle_radar.translation_m));
    auto& [still, all] = counts[scan.radar_id];
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const Eigen::Vector3d u(std::cos(scan.azimuth_rad[i]), std::sin(scan.azimuth_rad[i]), 0.0);
      still += std::abs(scan.range_rate_mps[i] + u.dot(v_radar)) < gate_mps ? 1.0 : 0.0;
      all += 1.0;
    }
  }
  std::map<std::string, double> shares;
  for (const auto& [radar, count] : counts) shares[radar] = count.first / count.second;
  return shares;
}

// Length of the reference track against the integral of the ego-velocity.
double TrackLengthRatio(const Drive& drive) {
  double track_m = 0.0;
  double travelled_m = 0.0;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    const DriveScan& a = drive.scans[i - 1];
    const DriveScan& b = drive.scans[i];
    track_m += (b.T_map_vehicle.translation_m - a.T_map_vehicle.translation_m).norm();
    travelled_m += b.scan.ego_velocity->linear_mps.norm() *
                   std::chrono::duration<double>(b.scan.stamp - a.scan.stamp).count();
  }
  return track_m / travelled_m;
}

TEST_F(Recordings, NuScenesHasAllSweepsOfAScene) {
  const Drive drive = Read(nuscenes_, "scene-0061");
  EXPECT_EQ(drive.place, "singapore-onenorth");
  const std::map<std::string, int> expected = {{"RADAR_BACK_LEFT", 253},
                                               {"RADAR_BACK_RIGHT", 243},
                                               {"RADAR_FRONT", 247},
                                               {"RADAR_FRONT_LEFT", 262},
                                               {"RADAR_FRONT_RIGHT", 258}};
  EXPECT_EQ(ScansPerRadar(drive), expected);
  EXPECT_NEAR(TrackLengthRatio(drive), 1.0, 0.05);
}

TEST_F(Recordings, NuScenesTargetsMostlyStandStill) {
  for (const char* scene : {"scene-0061", "scene-0655", "scene-0757", "scene-0796", "scene-1094"}) {
    for (const auto& [radar, share] : StaticShare(Read(nuscenes_, scene), 0.6)) {
      EXPECT_GT(share, 0.75) << scene << " " << radar;
    }
  }
}

TEST_F(Recordings, RadarScenesHasAllScansOfASequence) {
  const Drive drive = Read(radarscenes_, "sequence_108");
  const std::map<std::string, int> expected = {
      {"radar_1", 2043}, {"radar_2", 2007}, {"radar_3", 2023}, {"radar_4", 2024}};
  EXPECT_EQ(ScansPerRadar(drive), expected);
  EXPECT_NEAR(TrackLengthRatio(drive), 1.0, 0.05);
}

TEST_F(Recordings, RadarScenesTargetsMostlyStandStill) {
  for (const auto& [radar, share] : StaticShare(Read(radarscenes_, "sequence_108"), 0.6)) {
    EXPECT_GT(share, 0.9) << radar;
  }
}

}  // namespace
}  // namespace dcloc
