#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

class AdminServiceTest : public ::testing::Test {
 protected:
  AdminServiceTest() {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  }

  std::unique_ptr<TestSession> OpenSession(const std::string& vehicle_id) {
    auto session = std::make_unique<TestSession>(*server_.localization);
    v1::OpenSession open = OpenMessage();
    open.set_vehicle_id(vehicle_id);
    EXPECT_TRUE(session->Open(open));
    EXPECT_TRUE(session->Read().has_value());
    return session;
  }

  v1::GetServerStateResponse State() {
    Call call;
    v1::GetServerStateResponse response;
    EXPECT_TRUE(server_.admin->GetServerState(&call, {}, &response).ok());
    return response;
  }

  TestServer server_;
};

TEST_F(AdminServiceTest, TheStateCountsSessionsMapsAndScans) {
  const v1::GetServerStateResponse before = State();
  EXPECT_EQ(before.session_count(), 0);
  EXPECT_EQ(before.loaded_map_count(), 0);
  EXPECT_GE(before.worker_count(), 1);
  EXPECT_TRUE(before.stub_matcher());
  EXPECT_FALSE(before.server_version().empty());

  const auto session = OpenSession("car-1");
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(session->Localize(ScanMessage(i))->has_result());
  v1::Scan malformed;
  malformed.set_sequence_number(3);
  ASSERT_TRUE(session->Localize(malformed)->has_rejected());
  const v1::GetServerStateResponse after = State();
  EXPECT_EQ(after.session_count(), 1);
  EXPECT_EQ(after.loaded_map_count(), 1);
  EXPECT_EQ(after.scan_count(), 3);
  EXPECT_EQ(after.rejected_scan_count(), 1);
}

TEST_F(AdminServiceTest, SessionsAreListedInPages) {
  std::vector<std::unique_ptr<TestSession>> sessions;
  for (const char* vehicle : {"car-1", "car-2", "car-3"}) {
    sessions.push_back(OpenSession(vehicle));
  }
  ASSERT_TRUE(sessions[1]->Localize(ScanMessage(1))->has_result());
  v1::ListSessionsRequest request;
  request.set_page_size(2);
  std::vector<v1::Session> listed;
  do {
    Call call;
    v1::ListSessionsResponse response;
    ASSERT_TRUE(server_.admin->ListSessions(&call, request, &response).ok());
    EXPECT_LE(response.sessions_size(), 2);
    for (const v1::Session& session : response.sessions()) listed.push_back(session);
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  ASSERT_EQ(listed.size(), 3U);
  std::vector<std::string> vehicles;
  for (const v1::Session& session : listed) {
    vehicles.push_back(session.vehicle_id());
    EXPECT_EQ(session.map_name(), "town");
    EXPECT_EQ(session.map_version(), 1);
    EXPECT_THAT(session.peer(), ::testing::HasSubstr("127.0.0.1"));
    const bool drove = session.vehicle_id() == "car-2";
    EXPECT_EQ(session.scan_count(), drove ? 1 : 0);
    EXPECT_EQ(session.state(),
              drove ? v1::LOCALIZATION_STATE_DEAD_RECKONING : v1::LOCALIZATION_STATE_UNSPECIFIED);
    EXPECT_EQ(session.has_pose(), drove);
    EXPECT_EQ(session.pose().covariance_size(), drove ? 36 : 0);
    EXPECT_EQ(session.pose_stamp_ns(), drove ? ScanMessage(1).stamp_ns() : 0);
  }
  EXPECT_THAT(vehicles, ::testing::UnorderedElementsAre("car-1", "car-2", "car-3"));
}

/// The bytes of a unary answer, for services whose protos are not ours.
std::string CallByName(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                       const std::string& request) {
  grpc::GenericStub stub(channel);
  Call call;
  grpc::CompletionQueue queue;
  const grpc::Slice slice(request);
  const auto rpc = stub.PrepareUnaryCall(&call, method, grpc::ByteBuffer(&slice, 1), &queue);
  rpc->StartCall();
  grpc::ByteBuffer response;
  grpc::Status status;
  rpc->Finish(&response, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  EXPECT_TRUE(queue.Next(&tag, &ok));
  EXPECT_TRUE(status.ok()) << status.error_message();
  grpc::Slice answer;
  EXPECT_TRUE(response.DumpToSingleSlice(&answer).ok());
  return {answer.begin(), answer.end()};
}

/// Whether the service, or with no name the server, says that it serves.
bool Serves(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  // HealthCheckRequest{service}: field 1, length-delimited.
  const std::string request = "\x0a" + std::string(1, static_cast<char>(service.size())) + service;
  const std::string answer = CallByName(channel, "/grpc.health.v1.Health/Check", request);
  // HealthCheckResponse{status}: field 1, varint 1 for SERVING and 2 for NOT_SERVING.
  EXPECT_TRUE(answer == "\x08\x01" || answer == "\x08\x02") << service;
  return answer == "\x08\x01";
}

TEST_F(AdminServiceTest, HealthIsToldOfEachService) {
  for (const char* service :
       {"", "dcloc.v1.LocalizationService", "dcloc.v1.MapService", "dcloc.v1.AdminService"}) {
    EXPECT_TRUE(Serves(server_.channel, service)) << service;
  }
  Call call;
  v1::DrainResponse response;
  ASSERT_TRUE(server_.admin->Drain(&call, {}, &response).ok());
  EXPECT_FALSE(Serves(server_.channel, ""));
  EXPECT_FALSE(Serves(server_.channel, "dcloc.v1.LocalizationService"));
  EXPECT_TRUE(Serves(server_.channel, "dcloc.v1.MapService"));
  EXPECT_TRUE(Serves(server_.channel, "dcloc.v1.AdminService"));
}

TEST_F(AdminServiceTest, ReflectionKnowsOurServices) {
  grpc::GenericStub stub(server_.channel);
  Call call;
  grpc::CompletionQueue queue;
  const auto stream = stub.PrepareCall(
      &call, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", &queue);
  void* tag = nullptr;
  bool ok = false;
  stream->StartCall(nullptr);
  ASSERT_TRUE(queue.Next(&tag, &ok) && ok);
  // ServerReflectionRequest{list_services: ""}: field 7, empty.
  const grpc::Slice request_slice(std::string("\x3a\x00", 2));
  stream->Write(grpc::ByteBuffer(&request_slice, 1), nullptr);
  ASSERT_TRUE(queue.Next(&tag, &ok) && ok);
  grpc::ByteBuffer response;
  stream->Read(&response, nullptr);
  ASSERT_TRUE(queue.Next(&tag, &ok) && ok);
  grpc::Slice slice;
  ASSERT_TRUE(response.DumpToSingleSlice(&slice).ok());
  const std::string text(slice.begin(), slice.end());
  for (const char* service : {"dcloc.v1.LocalizationService", "dcloc.v1.MapService",
                              "dcloc.v1.AdminService", "grpc.health.v1.Health"}) {
    EXPECT_THAT(text, ::testing::HasSubstr(service));
  }
  call.TryCancel();
  grpc::Status status;
  stream->Finish(&status, nullptr);
  ASSERT_TRUE(queue.Next(&tag, &ok));
}

}  // namespace
}  // namespace dcloc::server
