#include "server/rpc/unparsed_requests.h"

#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "server/identity/method_permissions.h"
#include "server/rpc/wire.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

grpc::ByteBuffer BytesOf(const std::string& text) {
  const grpc::Slice slice(text);
  return {&slice, 1};
}

/// How a call of `path` ends that sends `messages`.
grpc::Status EndOf(const TestServer& server, const std::string& path,
                   const std::vector<grpc::ByteBuffer>& messages) {
  grpc::GenericStub stub(server.channel);
  Call call;
  grpc::CompletionQueue queue;
  const auto stream = stub.PrepareCall(&call, path, &queue);
  void* tag = nullptr;
  bool ok = false;
  stream->StartCall(nullptr);
  queue.Next(&tag, &ok);
  for (const grpc::ByteBuffer& message : messages) {
    stream->Write(message, nullptr);
    queue.Next(&tag, &ok);
  }
  stream->WritesDone(nullptr);
  queue.Next(&tag, &ok);
  grpc::ByteBuffer response;
  for (ok = true; ok;) {
    stream->Read(&response, nullptr);
    queue.Next(&tag, &ok);
  }
  grpc::Status status;
  stream->Finish(&status, nullptr);
  queue.Next(&tag, &ok);
  return status;
}

/// "/package.Service/Method" of "package.Service.Method".
std::string PathOf(std::string method) {
  method[method.rfind('.')] = '/';
  return "/" + method;
}

TEST(UnparsedRequestsTest, EachRpcSaysThatAMessageDoesNotParse) {
  const TestServer server;
  for (const MethodPermission& entry : MethodPermissions()) {
    const grpc::Status status =
        EndOf(server, PathOf(std::string(entry.method)), {BytesOf("\xff\xff\xff")});
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << entry.method;
    EXPECT_THAT(status.error_message(), HasSubstr("does not parse as dcloc.v1.")) << entry.method;
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
