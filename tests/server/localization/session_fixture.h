#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {

inline v1::OpenSession ResumableOpen() {
  v1::OpenSession open = OpenMessage();
  open.set_resumable(true);
  return open;
}

inline v1::OpenSession ResumeOpen(const std::string& token,
                                  const std::string& vehicle_id = "car-1") {
  v1::OpenSession open;
  open.set_vehicle_id(vehicle_id);
  open.set_resume_token(token);
  return open;
}

/// A server with a map, and what one does with sessions.
class SessionFixture : public ::testing::Test {
 protected:
  explicit SessionFixture(const ServerConfig& config = TestServer::StubConfig()) : server_(config) {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  }

  std::unique_ptr<TestSession> Connect() {
    return std::make_unique<TestSession>(*server_.localization);
  }

  v1::SessionOpened Open(TestSession& session, const v1::OpenSession& open) {
    EXPECT_TRUE(session.Open(open));
    const auto opened = session.Read();
    EXPECT_TRUE(opened.has_value()) << session.Finish().error_message();
    return opened ? opened->opened() : v1::SessionOpened();
  }

  grpc::Status StatusOf(const v1::OpenSession& open) {
    TestSession session(*server_.localization);
    session.Open(open);
    return session.Finish();
  }

  v1::GetServerStateResponse State() {
    Call call;
    v1::GetServerStateResponse response;
    EXPECT_TRUE(server_.admin->GetServerState(&call, {}, &response).ok());
    return response;
  }

  v1::Session Get(const std::string& session_id) {
    Call call;
    v1::GetSessionRequest request;
    request.set_session_id(session_id);
    v1::GetSessionResponse response;
    EXPECT_TRUE(server_.admin->GetSession(&call, request, &response).ok());
    return response.session();
  }

  grpc::Status End(const std::string& session_id, const std::string& reason) {
    Call call;
    v1::EndSessionRequest request;
    request.set_session_id(session_id);
    request.set_reason(reason);
    v1::EndSessionResponse response;
    return server_.admin->EndSession(&call, request, &response);
  }

  void WaitUntilDetached(int count = 1) {
    ASSERT_TRUE(Eventually([&] { return State().detached_session_count() == count; }));
  }

  TestServer server_;
};

}  // namespace dcloc::server
