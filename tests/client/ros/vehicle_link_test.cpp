#include "client/ros/vehicle_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "tests/client/sdk/fake_server.h"

namespace dcloc::node {
namespace {

using client::FakeServer;
using client::LocalizeServerStream;
using Phase = LinkStatus::Phase;
using std::chrono::milliseconds;

bool Eventually(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(milliseconds(5));
  }
  return true;
}

v1::OpenSession Car() {
  v1::OpenSession open;
  open.set_vehicle_id("car");
  return open;
}

v1::Scan ScanOf(std::int64_t number) {
  v1::Scan scan;
  scan.set_sequence_number(number);
  scan.set_stamp_ns(number + 1);
  return scan;
}

TEST(VehicleLinkTest, ScansAreAnsweredOnceItIsOpen) {
  const FakeServer server(client::AnswerAll);
  std::atomic<int> answers{0};
  VehicleLink link(server.Channel(), {}, milliseconds(20),
                   [&](const v1::LocalizeResponse&) { ++answers; });
  EXPECT_EQ(link.status().phase, Phase::kWaiting);
  EXPECT_EQ(link.Send(ScanOf(0)).code(), absl::StatusCode::kUnavailable);
  link.Open(Car());
  ASSERT_TRUE(Eventually([&] { return link.is_open(); }));
  EXPECT_EQ(link.status().session_id, "session of car");
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(link.Send(ScanOf(i)).ok());
  EXPECT_TRUE(Eventually([&] { return answers == 3; }));
}

TEST(VehicleLinkTest, ASessionThatEndsIsFollowedByAnother) {
  const FakeServer server([](grpc::ServerContext&, LocalizeServerStream& stream) {
    client::AcceptOpen(stream);
    v1::LocalizeRequest request;
    stream.Read(&request);
    return grpc::Status(grpc::StatusCode::ABORTED, "an operator ended it");
  });
  VehicleLink link(server.Channel(), {.reconnect = std::nullopt}, milliseconds(20),
                   [](const v1::LocalizeResponse&) {});
  link.Open(Car());
  for (int count = 1; count <= 3; ++count) {
    ASSERT_TRUE(Eventually([&] { return link.status().session_count >= count; })) << count;
    EXPECT_TRUE(Eventually([&] { return link.Send(ScanOf(count)).ok(); }));
  }
}

TEST(VehicleLinkTest, AServerThatRefusesIsAskedAgainAndSaysWhy) {
  std::atomic<int> tries{0};
  const FakeServer server([&](grpc::ServerContext&, LocalizeServerStream&) {
    ++tries;
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "there is no map town");
  });
  VehicleLink link(server.Channel(), {}, milliseconds(20), [](const v1::LocalizeResponse&) {});
  link.Open(Car());
  EXPECT_TRUE(Eventually([&] { return tries >= 2; }));
  EXPECT_EQ(link.status().phase, Phase::kConnecting);
  EXPECT_THAT(link.status().text, ::testing::HasSubstr("there is no map town"));
}

TEST(VehicleLinkTest, APoseThatCameFirstIsThePriorOfTheFirstSessionAlone) {
  std::atomic<int> with_prior{0};
  std::atomic<int> without{0};
  const FakeServer server([&](grpc::ServerContext&, LocalizeServerStream& stream) {
    v1::LocalizeRequest request;
    stream.Read(&request);
    ++(request.open().has_initial_pose() ? with_prior : without);
    v1::LocalizeResponse opened;
    opened.mutable_opened()->set_session_id("s");
    stream.Write(opened);
    return grpc::Status(grpc::StatusCode::ABORTED, "idle");
  });
  VehicleLink link(server.Channel(), {.reconnect = std::nullopt}, milliseconds(20),
                   [](const v1::LocalizeResponse&) {});
  link.SetInitialPose(v1::PoseWithCovariance());
  link.Open(Car());
  EXPECT_TRUE(Eventually([&] { return without >= 2; }));
  EXPECT_EQ(with_prior, 1);
}

TEST(VehicleLinkTest, ItEndsSoonWhateverTheServerDoes) {
  const FakeServer server([](grpc::ServerContext& context, LocalizeServerStream& stream) {
    client::AcceptOpen(stream);
    while (!context.IsCancelled()) std::this_thread::sleep_for(milliseconds(5));
    return grpc::Status::CANCELLED;
  });
  const auto begin = std::chrono::steady_clock::now();
  {
    VehicleLink link(server.Channel(), {}, milliseconds(20), [](const v1::LocalizeResponse&) {});
    link.Open(Car());
    ASSERT_TRUE(Eventually([&] { return link.is_open(); }));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

}  // namespace
}  // namespace dcloc::node
