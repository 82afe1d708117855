#include "client/sdk/requests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <mutex>
#include <thread>
#include <vector>

#include "client/sdk/session.h"
#include "tests/client/sdk/fake_server.h"

namespace dcloc::client {
namespace {

TEST(RequestsTest, ARadarLooksWhereItsYawSays) {
  const v1::OpenSession open =
      OpenRequest("car-17", "town", {{"front", {3.5, 0.0, 0.5}, 0.0, 0.04}, {"left", {}, 1.2}});
  EXPECT_EQ(open.vehicle_id(), "car-17");
  EXPECT_EQ(open.map_name(), "town");
  ASSERT_EQ(open.rig().radars_size(), 2);
  EXPECT_EQ(open.rig().radars(0).t_vehicle_radar().translation_m().x(), 3.5);
  EXPECT_EQ(open.rig().radars(0).t_vehicle_radar().translation_m().z(), 0.5);
  EXPECT_EQ(open.rig().radars(0).t_vehicle_radar().rotation().w(), 1.0);
  EXPECT_EQ(open.rig().radars(0).beta_s(), 0.04);
  const v1::Quaternion& left = open.rig().radars(1).t_vehicle_radar().rotation();
  EXPECT_NEAR(2.0 * std::atan2(left.z(), left.w()), 1.2, 1e-12);
}

TEST(RequestsTest, AScanHasARowForEachTarget) {
  const Target targets[] = {{10.0F, 0.1F, -3.0F}, {20.0F, -0.2F, 4.0F}};
  const v1::Scan scan = ScanOf("front", 17, targets);
  EXPECT_EQ(scan.radar_id(), "front");
  EXPECT_EQ(scan.stamp_ns(), 17);
  ASSERT_EQ(scan.range_m_size(), 2);
  EXPECT_EQ(scan.range_m(1), 20.0F);
  EXPECT_EQ(scan.azimuth_rad(1), -0.2F);
  EXPECT_EQ(scan.range_rate_mps(0), -3.0F);
}

TEST(RequestsTest, ScansAreNumberedOnAndNoAnswerNeedsToBeTaken) {
  std::vector<std::int64_t> numbers;
  std::mutex mutex;
  const FakeServer server([&](grpc::ServerContext&, LocalizeServerStream& stream) {
    AcceptOpen(stream);
    v1::LocalizeRequest request;
    while (stream.Read(&request)) {
      if (!request.has_scan()) continue;
      const std::lock_guard lock(mutex);
      numbers.push_back(request.scan().sequence_number());
      v1::LocalizeResponse response;
      response.mutable_rejected()->set_sequence_number(request.scan().sequence_number());
      stream.Write(response);
    }
    return grpc::Status::OK;
  });
  const auto session =
      Session::Connect({.server = server.address()}, OpenRequest("car", "town", {}),
                       {.when_full = FullQueue::kBlock,
                        .max_unread_answer_count = 3,
                        .unread_answers = UnreadAnswers::kForgetOldest});
  ASSERT_TRUE(session.ok()) << session.status();
  ASSERT_TRUE((*session)->SendTargets("front", 1, {}).ok());
  v1::Scan given;
  given.set_sequence_number(10);
  ASSERT_TRUE((*session)->Send(given).ok());
  for (int i = 0; i < 200; ++i) ASSERT_TRUE((*session)->SendTargets("front", 2 + i, {}).ok());
  (*session)->CloseSending();
  std::vector<std::int64_t> taken;
  while ((*session)->EndStatus().code() == absl::StatusCode::kFailedPrecondition) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  while (const auto answer = (*session)->Next()) {
    taken.push_back(answer->rejected().sequence_number());
  }
  EXPECT_TRUE((*session)->EndStatus().ok()) << (*session)->EndStatus();
  EXPECT_EQ(taken, (std::vector<std::int64_t>{208, 209, 210}));
  const std::lock_guard lock(mutex);
  ASSERT_EQ(numbers.size(), 202U);
  EXPECT_EQ(numbers[0], 0);
  EXPECT_EQ(numbers[1], 10);
  EXPECT_EQ(numbers[2], 11);
}

TEST(RequestsTest, WhereToConnectIsChecked) {
  const auto session = Session::Connect({.server = "127.0.0.1:1", .tls_cert = "a"}, {});
  EXPECT_EQ(session.status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc::client
