#include <gtest/gtest.h>

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "client/sdk/session.h"
#include "tests/client/sdk/fake_server.h"
#include "tests/client/sdk/pose/answers.h"

namespace dcloc::client {
namespace {

/// Answers each scan with a pose 2 m further along x.
grpc::Status AnswerWithPoses(grpc::ServerContext&, LocalizeServerStream& stream) {
  AcceptOpen(stream);
  v1::LocalizeRequest request;
  double x = 0.0;
  while (stream.Read(&request)) {
    v1::LocalizeResponse response;
    *response.mutable_result() = AnswerAt(0, x);
    response.mutable_result()->set_stamp_ns(request.scan().stamp_ns());
    response.mutable_result()->set_sequence_number(request.scan().sequence_number());
    stream.Write(response);
    x += 2.0;
  }
  return grpc::Status::OK;
}

v1::Scan ScanAt(std::int64_t number) {
  v1::Scan scan;
  scan.set_sequence_number(number);
  scan.set_stamp_ns(At(100 * number));
  *scan.mutable_ego_velocity() = Driving(20.0);
  return scan;
}

TEST(SessionPoseTest, APoseIsToldBetweenAnswersAndAfterThem) {
  const FakeServer server(AnswerWithPoses);
  v1::OpenSession open;
  open.set_vehicle_id("car");
  const auto session = Session::Open(server.Channel(), open);
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ((*session)->PoseAt(At(0)).status().code(), absl::StatusCode::kFailedPrecondition);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE((*session)->Send(ScanAt(i)).ok());
    ASSERT_TRUE((*session)->Next().has_value());
  }
  EXPECT_NEAR((*session)->PoseAt(At(150))->T_map_vehicle.translation_m[0], 3.0, 1e-9);
  EXPECT_NEAR((*session)->PoseAt(At(250))->T_map_vehicle.translation_m[0], 5.0, 1e-9);
  ASSERT_TRUE((*session)->AddEgoVelocity(At(300), Driving(10.0)).ok());
  EXPECT_NEAR((*session)->PoseAt(At(300))->T_map_vehicle.translation_m[0], 5.5, 1e-9);
  // It was told that it would be there at 6 m, and goes back slowly.
  EXPECT_NEAR((*session)->SmoothPoseAt(At(300))->T_map_vehicle.translation_m[0], 6.0, 1e-9);
  EXPECT_NEAR((*session)->SmoothPoseAt(At(700))->T_map_vehicle.translation_m[0], 9.8, 1e-9);
  EXPECT_EQ((*session)->PoseAt(At(701)).status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ((*session)->AddEgoVelocity(0, Driving(1.0)).code(), absl::StatusCode::kInvalidArgument);
}

TEST(SessionPoseTest, TicksAtTheirOwnRateMovePosesAndGoWithScans) {
  std::vector<double> speeds;
  std::vector<int> tick_counts;
  std::mutex mutex;
  const FakeServer server([&](grpc::ServerContext&, LocalizeServerStream& stream) {
    AcceptOpen(stream);
    v1::LocalizeRequest request;
    while (stream.Read(&request)) {
      {
        const std::lock_guard lock(mutex);
        const v1::Scan& scan = request.scan();
        speeds.push_back(scan.has_ego_velocity() ? scan.ego_velocity().linear_mps().x() : -1.0);
        tick_counts.push_back(scan.motion().stamp_offset_ns_size());
      }
      v1::LocalizeResponse response;
      *response.mutable_result() = AnswerAt(0, 5.0);
      response.mutable_result()->set_stamp_ns(request.scan().stamp_ns());
      response.mutable_result()->set_sequence_number(request.scan().sequence_number());
      stream.Write(response);
    }
    return grpc::Status::OK;
  });
  const auto session = Session::Open(server.Channel(), v1::OpenSession());
  ASSERT_TRUE(session.ok()) << session.status();
  const auto send = [&](std::int64_t number, bool with_velocity) {
    v1::Scan scan = ScanAt(number);
    if (!with_velocity) scan.clear_ego_velocity();
    ASSERT_TRUE((*session)->Send(scan).ok());
    ASSERT_TRUE((*session)->Next().has_value());
  };
  send(0, false);
  for (int i = 10; i <= 11; ++i) {
    ASSERT_TRUE((*session)->AddMotion({.stamp_ns = At(20 * i - 110), .speed_mps = i}).ok());
  }
  ASSERT_TRUE((*session)->AddMotion({.stamp_ns = At(95), .yaw_rate_radps = 0.0}).ok());
  send(1, false);
  send(2, true);
  EXPECT_EQ(speeds, std::vector<double>({-1.0, 10.5, 20.0}));
  EXPECT_EQ(tick_counts, std::vector<int>({0, 3, 3}));  // the first one of a session has none
  ASSERT_TRUE((*session)->AddMotion({At(250), 20.0, 0.0}).ok());
  ASSERT_TRUE((*session)->AddMotion({At(260), 20.0, 0.0}).ok());
  EXPECT_NEAR((*session)->PoseAt(At(260))->T_map_vehicle.translation_m[0], 5.0 + 1.2, 1e-9);
  EXPECT_EQ((*session)->AddMotion({0, 1.0, 0.0}).code(), absl::StatusCode::kInvalidArgument);
}

TEST(SessionPoseTest, OptionsThatCannotBeAreRefused) {
  SessionOptions options;
  options.pose.bleed_mps = 0.0;
  EXPECT_NE(std::string(Validate(options).message()).find("pose.bleed_mps"), std::string::npos);
}

}  // namespace
}  // namespace dcloc::client
