#include "server/net/awaited_requests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "google/protobuf/descriptor.h"
#include "server/identity/method_permissions.h"
#include "tests/server/fixtures/silent_call.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

ServerConfig Config() {
  ServerConfig config = TestServer::StubConfig();
  config.open_timeout_ms = 1500;
  config.max_unopened_stream_count_per_peer = 100;
  return config;
}

v1::GetServerStateResponse StateOf(const TestServer& server) {
  Call call;
  v1::GetServerStateResponse state;
  EXPECT_TRUE(server.admin->GetServerState(&call, {}, &state).ok());
  return state;
}

/// The paths of all methods that take a single request.
std::vector<std::string> PathsOfSingleRequests() {
  std::vector<std::string> paths = {"/grpc.health.v1.Health/Check", "/grpc.health.v1.Health/Watch"};
  for (const MethodPermission& entry : MethodPermissions()) {
    const std::string name(entry.method);
    if (google::protobuf::DescriptorPool::generated_pool()
            ->FindMethodByName(name)
            ->client_streaming()) {
      continue;
    }
    const std::size_t dot = name.rfind('.');
    paths.push_back("/" + name.substr(0, dot) + "/" + name.substr(dot + 1));
  }
  return paths;
}

TEST(AwaitedRequestsTest, EachSingleRequestHasToComeInTime) {
  const TestServer server(Config());
  const std::vector<std::string> paths = PathsOfSingleRequests();
  std::vector<std::unique_ptr<SilentCall>> calls;
  calls.reserve(paths.size());
  for (const std::string& path : paths) {
    calls.push_back(std::make_unique<SilentCall>(server, path));
  }
  const int count = static_cast<int>(paths.size());
  EXPECT_TRUE(Eventually([&] { return StateOf(server).awaited_request_count() == count; }));
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const grpc::Status status = calls[i]->End();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED) << paths[i];
    EXPECT_THAT(status.error_message(), HasSubstr("open_timeout_ms, which is 1500")) << paths[i];
  }
  EXPECT_TRUE(Eventually([&] { return StateOf(server).awaited_request_count() == 0; }));
}

TEST(AwaitedRequestsTest, BeyondTheirNumberTheOldestGoes) {
  ServerConfig config = Config();
  config.open_timeout_ms = 60'000;
  config.max_unopened_stream_count_per_peer = 3;
  const TestServer server(config);
  std::vector<std::unique_ptr<SilentCall>> calls;
  calls.reserve(4);
  for (int i = 0; i < 4; ++i) {
    calls.push_back(std::make_unique<SilentCall>(server, "/dcloc.v1.MapService/ListMaps"));
  }
  const grpc::Status status = calls.front()->End();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("max_unopened_stream_count_per_peer is 3"));
  // This one waits for a moment too, and another one goes for it.
  EXPECT_EQ(StateOf(server).awaited_request_count(), 2);
}

TEST(AwaitedRequestsTest, ACallThatItsPeerCancelsIsForgotten) {
  ServerConfig config = Config();
  config.open_timeout_ms = 60'000;
  const TestServer server(config);
  SilentCall call(server, "/dcloc.v1.MapService/ListMaps");
  ASSERT_TRUE(Eventually([&] { return StateOf(server).awaited_request_count() == 1; }));
  call.Cancel();
  EXPECT_TRUE(Eventually([&] { return StateOf(server).awaited_request_count() == 0; }));
}

TEST(AwaitedRequestsTest, TheyHoldUpNoStop) {
  ServerConfig config = Config();
  config.open_timeout_ms = 60'000;
  const TestServer server(config);
  SilentCall call(server, "/dcloc.v1.MapService/ListMaps");
  ASSERT_TRUE(Eventually([&] { return StateOf(server).awaited_request_count() == 1; }));
  const auto begin = std::chrono::steady_clock::now();
  server.server->Shutdown(std::chrono::seconds(30));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  EXPECT_FALSE(call.End().ok());
}

}  // namespace
}  // namespace dcloc::server
