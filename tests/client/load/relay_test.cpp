#include "client/load/relay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/load/vehicle_link.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::load {
namespace {

using ::testing::HasSubstr;

TEST(RelayTest, WhatItCutsIsBrokenForBothAndWhatComesLaterIsCarried) {
  const server::TestServer server;
  const std::vector<std::byte> map = server::SmallMap();
  v1::UploadMapResponse response;
  ASSERT_TRUE(server::UploadMap(*server.maps, server::HeaderOf(map), map, &response).ok());
  const auto link = MakeLink({.server = server.server->address()}, /*breaks=*/true);
  ASSERT_TRUE(link.ok()) << link.status();
  const auto stub = v1::LocalizationService::NewStub(link->channel);
  v1::OpenSession open = server::OpenMessage();
  open.set_resumable(true);

  server::TestSession session(*stub);
  ASSERT_TRUE(session.Open(open));
  const auto opened = session.Read();
  ASSERT_TRUE(opened.has_value());
  ASSERT_TRUE(session.Localize(server::ScanMessage(0)).has_value());
  link->relay->Cut();
  EXPECT_EQ(session.Finish().error_code(), grpc::StatusCode::UNAVAILABLE)
      << "it is the connection that broke, not the call that was cancelled";
  EXPECT_TRUE(server::Eventually([&] {
    server::Call call;
    v1::ListSessionsResponse sessions;
    return server.admin->ListSessions(&call, {}, &sessions).ok() && sessions.sessions_size() == 1 &&
           sessions.sessions(0).detached();
  }));

  server::TestSession again(*stub);
  open.set_resume_token(opened->opened().resume_token());
  ASSERT_TRUE(again.Open(open));
  const auto resumed = again.Read();
  ASSERT_TRUE(resumed.has_value()) << again.Finish().error_message();
  EXPECT_TRUE(resumed->opened().resumed());
  EXPECT_TRUE(again.Localize(server::ScanMessage(1)).has_value());
}

TEST(RelayTest, AServerThatIsNotThereIsLikeOneThatDoesNotAnswer) {
  const auto relay = Relay::Start("127.0.0.1:1");
  ASSERT_TRUE(relay.ok()) << relay.status();
  const auto channel = client::MakeChannel({.server = (*relay)->address()});
  EXPECT_FALSE((*channel)->WaitForConnected(std::chrono::system_clock::now() +
                                            std::chrono::milliseconds(300)));
}

TEST(RelayTest, AnAddressThatIsNoneIsNamed) {
  const absl::Status status = Relay::Start("no.such.host.invalid:1").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no.such.host.invalid:1"));
}

TEST(RelayTest, ATokenGoesNotInPlaintextToWhereItLeads) {
  const auto link = MakeLink({.server = "192.0.2.1:50051", .token_file = "token"}, true);
  EXPECT_EQ(link.status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc::load
