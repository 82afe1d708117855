#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/fixtures/test_server.h"
#include "tests/server/fixtures/town_drive.h"

namespace dcloc::server {
namespace {

/// All answers to the drive, without what a clock or chance gives.
std::vector<std::string> LocalizeDrive(const TestServer& server, const TownDrive& drive,
                                       bool with_prior = true) {
  TestSession session(*server.localization);
  v1::OpenSession open = drive.Open();
  if (!with_prior) open.clear_initial_pose();
  EXPECT_TRUE(session.Open(open));
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
  threads.reserve(together.size());
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

// Those without a prior search on other threads than those that track, and move to theirs when they
// are found.
TEST(DeterminismTest, BlindStartsBesideTrackersChangeNoBit) {
  const TownDrive drive;
  ServerConfig config;
  config.worker_count = 2;
  const TestServer server(config);
  v1::UploadMapResponse response;
  const grpc::Status status = UploadMap(*server.maps, HeaderOf(drive.map), drive.map, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();

  const std::vector<std::string> tracker = LocalizeDrive(server, drive);
  const std::vector<std::string> blind = LocalizeDrive(server, drive, /*with_prior=*/false);
  EXPECT_EQ(LastOf(blind).state(), v1::LOCALIZATION_STATE_TRACKING);
  std::vector<std::vector<std::string>> together(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < together.size(); ++i) {
    threads.emplace_back([&, i] { together[i] = LocalizeDrive(server, drive, i % 2 == 0); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < together.size(); ++i) {
    EXPECT_EQ(together[i], i % 2 == 0 ? tracker : blind) << i;
  }
}

}  // namespace
}  // namespace dcloc::server
