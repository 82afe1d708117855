#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "client/simulation/simulation.h"
#include "core/map/map_builder.h"
#include "server/convert/geometry.h"
#include "tests/server/test_server.h"

namespace dcloc::server {
namespace {

/// A short drive through a simulated town, and the map of another one.
struct TownDrive {
  TownDrive() {
    SimulationOptions options;
    options.length_m = 200.0;
    const std::vector<PassOptions> passes = Passes(options);
    const Drive mapping = *SimulatePass(options, passes[0]);
    MapBuilder builder = *MapBuilder::Create(mapping.rig, {.name = "town"});
    for (const DriveScan& scan : mapping.scans) {
      EXPECT_TRUE(builder.Add(scan.scan, scan.T_map_vehicle, *scan.scan.ego_velocity).ok());
    }
    map = *builder.Build();
    live = *SimulatePass(options, passes[1]);
  }

  v1::OpenSession Open() const {
    v1::OpenSession open = OpenMessage();
    const RadarModel& model = live.rig.radars[0];
    v1::RadarModel* radar = open.mutable_rig()->mutable_radars(0);
    radar->set_radar_id(model.id);
    convert::ToProto(model.T_vehicle_radar, radar->mutable_t_vehicle_radar());
    radar->set_beta_s(model.beta_s);
    radar->set_range_sigma_m(model.range_sigma_m);
    radar->set_range_rate_sigma_mps(model.range_rate_sigma_mps);
    radar->set_azimuth_sigma_rad(model.azimuth_sigma_rad);
    convert::ToProto(live.scans[0].T_map_vehicle, open.mutable_initial_pose()->mutable_pose());
    return open;
  }

  std::vector<std::byte> map;
  Drive live;
};

/// All answers to the drive, without what a clock or chance gives.
std::vector<std::string> LocalizeDrive(const TestServer& server, const TownDrive& drive) {
  TestSession session(*server.localization);
  EXPECT_TRUE(session.Open(drive.Open()));
  EXPECT_TRUE(session.Read().has_value());
  std::vector<std::string> answers;
  for (std::size_t i = 0; i < drive.live.scans.size(); ++i) {
    auto answer =
        session.Localize(MessageOf(drive.live.scans[i].scan, static_cast<std::int64_t>(i)));
    EXPECT_TRUE(answer && answer->has_result()) << i;
    if (!answer || !answer->has_result()) break;
    answer->mutable_result()->clear_timings();
    answers.push_back(answer->SerializeAsString());
  }
  session.CloseSending();
  EXPECT_TRUE(session.Finish().ok());
  return answers;
}

v1::LocalizationResult LastOf(const std::vector<std::string>& answers) {
  v1::LocalizeResponse response;
  EXPECT_TRUE(response.ParseFromString(answers.back()));
  return response.result();
}

TEST(DeterminismTest, EightSessionsAtOnceEqualOneAloneToTheBit) {
  const TownDrive drive;
  ServerConfig config;
  config.worker_count = 4;
  const TestServer server(config);
  v1::UploadMapResponse response;
  const grpc::Status status = UploadMap(*server.maps, HeaderOf(drive.map), drive.map, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();

  const std::vector<std::string> alone = LocalizeDrive(server, drive);
  ASSERT_EQ(alone.size(), drive.live.scans.size());
  std::vector<std::vector<std::string>> together(8);
  std::vector<std::thread> threads;
  for (auto& answers : together) {
    threads.emplace_back([&] { answers = LocalizeDrive(server, drive); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& answers : together) EXPECT_EQ(answers, alone);

  // Equal is not enough: the drive must have been localized.
  const v1::LocalizationResult last = LastOf(alone);
  EXPECT_EQ(last.state(), v1::LOCALIZATION_STATE_TRACKING);
  const Eigen::Vector3d truth = drive.live.scans.back().T_map_vehicle.translation_m;
  const v1::Vector3& position = last.pose().pose().translation_m();
  EXPECT_LT(std::hypot(position.x() - truth.x(), position.y() - truth.y()), 1.0);
}

}  // namespace
}  // namespace dcloc::server
