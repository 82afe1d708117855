#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

TEST(DownloadTest, OneThatNobodyReadsLetsGoOfItsVersion) {
  ServerConfig config = TestServer::StubConfig();
  config.peer_timeout_ms = 3000;  // long enough for the first deletion to come in time
  const TestServer server(config);
  // More than what a connection's windows hold.
  const std::vector<std::byte> bytes = SmallMap("large", 5000);
  ASSERT_GT(bytes.size(), std::size_t{1} << 20);
  v1::UploadMapResponse uploaded;
  ASSERT_TRUE(UploadMap(*server.maps, HeaderOf(bytes), bytes, &uploaded).ok());
  Call call;
  v1::DownloadMapRequest request;
  request.set_map_name("town");
  const auto slow_reader = v1::MapService::NewStub(ChannelWithFixedWindows(*server.server));
  const auto reader = slow_reader->DownloadMap(&call, request);
  v1::DownloadMapResponse response;
  ASSERT_TRUE(reader->Read(&response));
  const auto remove = [&server] {
    Call delete_call;
    v1::DeleteMapRequest delete_request;
    delete_request.set_map_name("town");
    v1::DeleteMapResponse deleted;
    return server.maps->DeleteMap(&delete_call, delete_request, &deleted);
  };
  EXPECT_THAT(remove().error_message(), HasSubstr("in use"));
  EXPECT_TRUE(Eventually([&] { return remove().ok(); }));
  while (reader->Read(&response)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

}  // namespace
}  // namespace dcloc::server
