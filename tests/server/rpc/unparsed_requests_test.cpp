#include "server/rpc/unparsed_requests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "server/identity/method_permissions.h"
#include "server/rpc/wire.h"
#include "tests/server/fixtures/raw_call.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

TEST(UnparsedRequestsTest, EachRpcSaysThatAMessageDoesNotParse) {
  const TestServer server;
  for (const MethodPermission& entry : MethodPermissions()) {
    const grpc::Status status =
        EndOf(server, PathOf(std::string(entry.method)), {BytesOf("\xff\xff\xff")});
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << entry.method;
    EXPECT_THAT(status.error_message(), HasSubstr("does not parse as dcloc.v1.")) << entry.method;
  }
}

// gRPC would unpack them before it looks at their size.
TEST(UnparsedRequestsTest, PackedMessagesAreNotUnpacked) {
  const TestServer server;
  for (const grpc_compression_algorithm kind : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    Call call;
    call.set_compression_algorithm(kind);
    v1::ListMapsRequest request;
    request.set_page_token(std::string(10'000, 'a'));
    v1::ListMapsResponse response;
    EXPECT_EQ(server.maps->ListMaps(&call, request, &response).error_code(),
              grpc::StatusCode::UNIMPLEMENTED);
  }
}

TEST(UnparsedRequestsTest, WhatIsNotThereIsUnimplemented) {
  const TestServer server;
  EXPECT_EQ(EndOf(server, "/dcloc.v1.MapService/Nothing", {BytesOf("\xff")}).error_code(),
            grpc::StatusCode::UNIMPLEMENTED);
}

TEST(UnparsedRequestsTest, AnOpenSessionDoesNotEndWellAfterOne) {
  const TestServer server;
  const std::vector<std::byte> bytes = SmallMap();
  v1::UploadMapResponse uploaded;
  ASSERT_TRUE(UploadMap(*server.maps, HeaderOf(bytes), bytes, &uploaded).ok());
  v1::LocalizeRequest open;
  *open.mutable_open() = OpenMessage();
  const grpc::Status status = EndOf(server, "/dcloc.v1.LocalizationService/Localize",
                                    {SerializeMessage(open), BytesOf("\xff\xff\xff")});
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("does not parse as dcloc.v1.LocalizeRequest"));
}

}  // namespace
}  // namespace dcloc::server
