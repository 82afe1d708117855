#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

class ShutdownTest : public ::testing::Test {
 protected:
  ShutdownTest() {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  }

  /// How long it takes.
  milliseconds Shutdown(milliseconds deadline) {
    const Clock::time_point begin = Clock::now();
    server_.server->Shutdown(deadline);
    return std::chrono::duration_cast<milliseconds>(Clock::now() - begin);
  }

  TestServer server_;
};

TEST_F(ShutdownTest, WithoutCallsItIsImmediate) {
  EXPECT_LT(Shutdown(milliseconds(5000)), milliseconds(2000));
}

TEST_F(ShutdownTest, OpenStreamsAreEndedWellBeforeTheDeadline) {
  std::vector<std::unique_ptr<TestSession>> sessions;
  for (int i = 0; i < 20; ++i) {
    sessions.push_back(std::make_unique<TestSession>(*server_.localization));
    // Some have not opened yet, some are idle, some have just had an answer.
    if (i % 4 == 0) continue;
    ASSERT_TRUE(sessions.back()->Open(OpenMessage()));
    ASSERT_TRUE(sessions.back()->Read().has_value());
    if (i % 2 == 0) {
      ASSERT_TRUE(sessions.back()->Localize(ScanMessage(1)).has_value());
    }
  }
  EXPECT_LT(Shutdown(milliseconds(20'000)), milliseconds(10'000));
  for (const auto& session : sessions) {
    EXPECT_EQ(session->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  }
}

TEST_F(ShutdownTest, ABusyStreamGetsAnAnswerToWhatWasTaken) {
  TestSession session(*server_.localization);
  ASSERT_TRUE(session.Open(OpenMessage()));
  ASSERT_TRUE(session.Read().has_value());
  std::thread writer([&] {
    for (int i = 0; session.Send(ScanMessage(i)); ++i) {
    }
  });
  ASSERT_TRUE(session.Read().has_value());
  std::thread stopper([&] { EXPECT_LT(Shutdown(milliseconds(20'000)), milliseconds(10'000)); });
  std::int64_t next = 1;
  while (const auto answer = session.Read()) EXPECT_EQ(answer->result().sequence_number(), next++);
  stopper.join();
  writer.join();
  EXPECT_EQ(session.Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(ShutdownTest, WhoDoesNotReadIsCutOffAtTheDeadline) {
  TestSession session(*server_.localization);
  ASSERT_TRUE(session.Open(OpenMessage()));
  ASSERT_TRUE(session.Read().has_value());
  std::atomic<int> sent = 0;
  std::thread writer([&] {
    while (session.Send(ScanMessage(sent, 2000))) ++sent;
  });
  ASSERT_TRUE(Eventually([&] { return StandsStill(sent); })) << "flow control must stop it";
  const milliseconds took = Shutdown(milliseconds(1000));
  EXPECT_GE(took, milliseconds(1000));
  EXPECT_LT(took, milliseconds(5000));
  writer.join();
  EXPECT_FALSE(session.Finish().ok());
}

TEST_F(ShutdownTest, AnUploadThatStandsStillIsCutOffAtTheDeadline) {
  const std::vector<std::byte> bytes = SmallMap();
  Call call;
  v1::UploadMapResponse response;
  const auto writer = server_.maps->UploadMap(&call, &response);
  v1::UploadMapRequest request;
  *request.mutable_header() = HeaderOf(bytes);
  ASSERT_TRUE(writer->Write(request));
  request.mutable_chunk()->set_data(bytes.data(), 10);
  ASSERT_TRUE(writer->Write(request));
  const std::filesystem::path incoming = server_.folder.path() / "store" / "incoming";
  ASSERT_TRUE(Eventually([&] { return !std::filesystem::is_empty(incoming); }));
  const milliseconds took = Shutdown(milliseconds(500));
  EXPECT_GE(took, milliseconds(500));
  EXPECT_LT(took, milliseconds(5000));
  EXPECT_FALSE(writer->Finish().ok());
}

TEST(DrainTest, SessionsThatNobodyCanResumeAreNotKept) {
  ServerConfig config = TestServer::StubConfig();
  config.drain_grace_ms = 100;
  const TestServer server(config);
  const std::vector<std::byte> bytes = SmallMap();
  v1::UploadMapResponse uploaded;
  ASSERT_TRUE(UploadMap(*server.maps, HeaderOf(bytes), bytes, &uploaded).ok());
  v1::OpenSession open = OpenMessage();
  open.set_resumable(true);
  TestSession left(*server.localization);
  ASSERT_TRUE(left.Open(open));
  ASSERT_TRUE(left.Read().has_value());
  left.Cancel();
  open.set_vehicle_id("car-2");
  TestSession attached(*server.localization);
  ASSERT_TRUE(attached.Open(open));
  ASSERT_TRUE(attached.Read().has_value());
  Call call;
  v1::DrainResponse response;
  ASSERT_TRUE(server.admin->Drain(&call, {}, &response).ok());
  EXPECT_TRUE(Eventually([&] {
    Call state_call;
    v1::GetServerStateResponse state;
    return server.admin->GetServerState(&state_call, {}, &state).ok() && state.session_count() == 0;
  })) << "a drained server is empty well before its sessions' timeout of a minute";
}

/// A server whose router is given some time, and a map for it.
class NoticeTest : public ::testing::Test {
 protected:
  NoticeTest() {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  }

  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.drain_notice_ms = static_cast<int>(kNotice.count());
    return config;
  }

  bool IsDraining() const {
    Call call;
    v1::GetServerStateResponse state;
    return server_.admin->GetServerState(&call, {}, &state).ok() && state.draining();
  }

  /// Opens a session of a vehicle that can move.
  bool Open(TestSession& session, const std::string& vehicle) const {
    v1::OpenSession open = OpenMessage();
    open.set_vehicle_id(vehicle);
    open.set_resumable(true);
    if (!session.Open(open)) return false;
    const auto answer = session.Read();
    return answer.has_value() && answer->has_opened();
  }

  /// Reads until the session is told to move; false when it ends without.
  static bool IsTold(TestSession& session) {
    while (const auto answer = session.Read()) {
      if (answer->has_ending()) {
        return answer->ending().reason() == v1::SESSION_END_REASON_DRAINING;
      }
    }
    return false;
  }

  static constexpr milliseconds kNotice{1000};
  TestServer server_{Config()};
};

TEST_F(NoticeTest, ADrainTakesSessionsUntilItIsOverAndThenTellsAllToMove) {
  TestSession before(*server_.localization);
  ASSERT_TRUE(Open(before, "before"));
  const Clock::time_point begin = Clock::now();
  Call call;
  v1::DrainResponse response;
  ASSERT_TRUE(server_.admin->Drain(&call, {}, &response).ok());
  EXPECT_EQ(response.session_count(), 1);
  EXPECT_TRUE(IsDraining());
  TestSession meanwhile(*server_.localization);
  ASSERT_TRUE(Open(meanwhile, "meanwhile"));
  EXPECT_TRUE(IsTold(before));
  EXPECT_TRUE(IsTold(meanwhile));
  EXPECT_GE(Clock::now() - begin, kNotice);
  TestSession late(*server_.localization);
  EXPECT_FALSE(Open(late, "late"));
  EXPECT_EQ(late.Finish().error_message(), "the server is draining");
}

TEST_F(NoticeTest, AServerThatStopsGivesItToo) {
  TestSession session(*server_.localization);
  ASSERT_TRUE(Open(session, "car"));
  const Clock::time_point begin = Clock::now();
  std::thread stopper([&] { server_.server->Shutdown(milliseconds(20'000)); });
  EXPECT_TRUE(Eventually([&] { return IsDraining(); }));
  EXPECT_TRUE(IsTold(session));
  EXPECT_GE(Clock::now() - begin, kNotice);
  session.CloseSending();
  session.Finish();
  stopper.join();
}

TEST_F(NoticeTest, WithoutCallsNobodyWaitsForIt) {
  const Clock::time_point begin = Clock::now();
  server_.server->Shutdown(milliseconds(20'000));
  EXPECT_LT(Clock::now() - begin, kNotice);
}

TEST_F(ShutdownTest, TwiceIsOnce) {
  Shutdown(milliseconds(1000));
  EXPECT_LT(Shutdown(milliseconds(1000)), milliseconds(500));
}

}  // namespace
}  // namespace dcloc::server
