#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dcloc/v1/admin_service.pb.h"
#include "tests/client/cli/fixtures/admin_commands.h"

// `dcloc server`.
namespace dcloc::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

using ServerCommandTest = AdminCommands;

TEST_F(ServerCommandTest, TheServerSaysHowItDoesAndIsDrained) {
  auto session = OpenSession("car-1");
  ASSERT_TRUE(session->Localize(server::ScanMessage(0)).has_value());
  const json before = json::parse(Dcloc(At("server status") + "--json").out);
  EXPECT_EQ(before["session_count"], 1);
  EXPECT_EQ(before["scan_count"], 1);
  EXPECT_EQ(before["draining"], false);
  EXPECT_EQ(before["stub_matcher"], true);
  EXPECT_THAT(Dcloc(At("server status")).out,
              AllOf(HasSubstr("1 of 1000"), Not(HasSubstr("draining"))));
  const json drained = json::parse(Dcloc(At("server drain") + "--wait-s 20 --json").out);
  EXPECT_EQ(drained["session_count"], 0);
  EXPECT_EQ(drained["draining"], true);
  EXPECT_THAT(Dcloc(At("server status")).out, HasSubstr("draining"));
}

TEST_F(ServerCommandTest, TheStatusHasAllThatTheServerTells) {
  const json status = json::parse(Dcloc(At("server status") + "--json").out);
  const google::protobuf::Descriptor& state = *v1::GetServerStateResponse::descriptor();
  for (int i = 0; i < state.field_count(); ++i) {
    const std::string& name = state.field(i)->name();
    EXPECT_TRUE(status.contains(name == "server_version" ? "version" : name)) << name;
  }
  EXPECT_EQ(status["max_unopened_stream_count"], 1000);
  EXPECT_TRUE(status["certificate_expire_time"].is_null()) << "without TLS";
  EXPECT_THAT(Dcloc(At("server status")).out,
              AllOf(HasSubstr("0 streams of 1000"), HasSubstr("none, plaintext")));
}

TEST_F(ServerCommandTest, WhatWasChangedIsSaidWithWhoDidIt) {
  const auto session = OpenSession("car-1");
  EXPECT_EQ(Dcloc(At("session end") + "car-1 --reason roadworks").exit_code, 0);
  const json operations = json::parse(Dcloc(At("server operations") + "--json").out);
  ASSERT_GE(operations.size(), 2U);
  EXPECT_EQ(operations[0]["method"], "dcloc.v1.AdminService.EndSession");
  EXPECT_EQ(operations[0]["principal"], "anonymous");
  EXPECT_EQ(operations[0]["status_code"], 0);
  EXPECT_THAT(Dcloc(At("server operations")).out,
              AllOf(HasSubstr("EndSession"), HasSubstr("roadworks"), HasSubstr("UploadMap")));
}

TEST_F(ServerCommandTest, ADrainThatTakesTooLongIsAnError) {
  server::ServerConfig config = server::TestServer::StubConfig();
  config.drain_grace_ms = 60'000;
  const server::TestServer slow(config);
  const std::vector<std::byte> map = server::SmallMap();
  v1::UploadMapResponse response;
  ASSERT_TRUE(server::UploadMap(*slow.maps, server::HeaderOf(map), map, &response).ok());
  server::TestSession session(*slow.localization);
  session.Open(server::OpenMessage());
  ASSERT_TRUE(session.Read().has_value());
  const Result result = Dcloc("server drain --wait-s 0.3 --server " + slow.server->address());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("1 sessions are still open after 0.3 s"));
  session.Cancel();
}

}  // namespace
}  // namespace dcloc::cli
