#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// Streams that hold nothing that a vehicle needs.
class UnopenedStreamTest : public ::testing::Test {
 protected:
  UnopenedStreamTest() : server_(Config()) {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  }

  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.max_session_count = 2;
    config.max_unopened_stream_count_per_peer = 5;
    config.open_timeout_ms = 1500;
    config.peer_timeout_ms = 1000;
    return config;
  }

  v1::GetServerStateResponse State() const {
    Call call;
    v1::GetServerStateResponse state;
    EXPECT_TRUE(server_.admin->GetServerState(&call, {}, &state).ok());
    return state;
  }

  TestServer server_;
};

TEST_F(UnopenedStreamTest, TheyTakeNoSessionsAndTheOldestGo) {
  std::vector<std::unique_ptr<TestSession>> silent;
  for (int i = 0; i < 8; ++i) {
    silent.push_back(std::make_unique<TestSession>(*server_.localization));
    ASSERT_TRUE(Eventually([&] { return State().unopened_stream_count() >= std::min(i + 1, 5); }));
  }
  EXPECT_EQ(State().unopened_stream_count(), 5);
  EXPECT_EQ(State().session_count(), 0);
  const grpc::Status status = silent.front()->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("max_unopened_stream_count_per_peer is 5"));
  TestSession vehicle(*server_.localization);
  ASSERT_TRUE(vehicle.Open(OpenMessage()));
  EXPECT_TRUE(vehicle.Read().has_value());
  EXPECT_TRUE(vehicle.Localize(ScanMessage(0))->has_result());
}

TEST_F(UnopenedStreamTest, TheirTimeIsLimited) {
  TestSession silent(*server_.localization);
  const grpc::Status status = silent.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_THAT(status.error_message(), HasSubstr("open_timeout_ms, which is 1500"));
  EXPECT_TRUE(Eventually([&] { return State().unopened_stream_count() == 0; }));
}

TEST_F(UnopenedStreamTest, LimitsHoldAndAreToldAtOnceWhenTheyChange) {
  ServerConfig config = Config();
  config.data = server_.folder.path() / "store";
  config.listen = "127.0.0.1:0";
  config.max_session_count = 7;
  config.max_unopened_stream_count = 1;
  config.max_unopened_stream_count_per_peer = 0;
  config.open_timeout_ms = 300;
  config.peer_timeout_ms = 500;
  ASSERT_TRUE(server_.server->Reload(config).ok());
  EXPECT_EQ(State().max_session_count(), 7);
  EXPECT_EQ(State().max_unopened_stream_count(), 1);
  TestSession first(*server_.localization);
  ASSERT_TRUE(Eventually([&] { return State().unopened_stream_count() == 1; }));
  TestSession second(*server_.localization);
  EXPECT_THAT(first.Finish().error_message(), HasSubstr("max_unopened_stream_count is 1"));
  EXPECT_THAT(second.Finish().error_message(), HasSubstr("which is 300"));
  Call call;
  v1::UploadMapResponse response;
  const auto upload = server_.maps->UploadMap(&call, &response);
  EXPECT_THAT(upload->Finish().error_message(), HasSubstr("which is 500"));
}

TEST_F(UnopenedStreamTest, AnOpenOneMayBeSilent) {
  TestSession vehicle(*server_.localization);
  ASSERT_TRUE(vehicle.Open(OpenMessage()));
  ASSERT_TRUE(vehicle.Read().has_value());
  std::this_thread::sleep_for(std::chrono::milliseconds(2000));
  EXPECT_TRUE(vehicle.Localize(ScanMessage(0))->has_result());
}

TEST_F(UnopenedStreamTest, WhoDoesNotReadItsAnswersIsCutOff) {
  TestSession stuck(*server_.localization);
  ASSERT_TRUE(stuck.Open(OpenMessage()));
  ASSERT_TRUE(stuck.Read().has_value());
  std::int64_t number = 0;
  while (stuck.Send(ScanMessage(number))) ++number;  // until the server ends it
  EXPECT_TRUE(Eventually([&] { return State().session_count() == 0; }));
}

TEST_F(UnopenedStreamTest, AnUploadThatStopsIsEnded) {
  Call call;
  v1::UploadMapResponse response;
  const auto writer = server_.maps->UploadMap(&call, &response);
  const std::vector<std::byte> bytes = SmallMap("another");
  v1::UploadMapRequest request;
  *request.mutable_header() = HeaderOf(bytes);
  ASSERT_TRUE(writer->Write(request));
  const grpc::Status status = writer->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_THAT(status.error_message(), HasSubstr("peer_timeout_ms, which is 1000"));
}

}  // namespace
}  // namespace dcloc::server
