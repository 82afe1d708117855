#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "server/app/storage.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

// Whose sessions are whose, and how much one principal may have of the server.
namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class SessionAccessTest : public ::testing::Test {
 protected:
  explicit SessionAccessTest(const ServerConfig& config = TestServer::StubConfig())
      : server_(config), identities_(*OpenIdentities(server_.folder.path() / "store")) {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
    car_ = Token({.name = "car-1", .role = Role::kVehicle});
    ops_ = Token({.name = "ops", .role = Role::kOperator});
  }

  std::string Token(const Principal& principal) const {
    return *identities_->Create(Proof::kToken, principal, {});
  }

  std::unique_ptr<TestSession> Open(const std::string& token, const v1::OpenSession& open) const {
    auto session = std::make_unique<TestSession>(*server_.localization, token);
    EXPECT_TRUE(session->Open(open));
    return session;
  }

  /// What becomes of a session that is not to be opened.
  grpc::Status Refusal(const std::string& token, const v1::OpenSession& open) const {
    TestSession session(*server_.localization, token);
    // It may be refused before the message is written.
    session.Open(open);
    session.CloseSending();
    return session.Finish();
  }

  static v1::OpenSession OpenOf(const std::string& vehicle_id) {
    v1::OpenSession open = OpenMessage();
    open.set_vehicle_id(vehicle_id);
    open.set_resumable(true);
    return open;
  }

  TestServer server_;
  const std::unique_ptr<IdentityStore> identities_;
  std::string car_;
  std::string ops_;
};

TEST_F(SessionAccessTest, AVehicleDrivesOnlyAsItself) {
  EXPECT_TRUE(Open(car_, OpenOf("car-1"))->Read().has_value());
  const grpc::Status status = Refusal(car_, OpenOf("car-2"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_THAT(status.error_message(), AllOf(HasSubstr("car-1"), HasSubstr("car-2")));
  EXPECT_TRUE(Open(ops_, OpenOf("car-2"))->Read().has_value()) << "an operator drives any";
}

TEST_F(SessionAccessTest, AResumeTokenIsItsPrincipalsAlone) {
  const auto session = Open(car_, OpenOf("car-1"));
  const auto opened = session->Read();
  ASSERT_TRUE(opened.has_value());
  v1::OpenSession resume;
  resume.set_vehicle_id("car-1");
  resume.set_resume_token(opened->opened().resume_token());
  const grpc::Status status = Refusal(ops_, resume);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_THAT(status.error_message(), HasSubstr("another principal"));
  EXPECT_TRUE(session->Localize(ScanMessage(0)).has_value()) << "and it was not taken over";
  const auto resumed = Open(car_, resume)->Read();
  ASSERT_TRUE(resumed.has_value());
  EXPECT_TRUE(resumed->opened().resumed());
}

TEST_F(SessionAccessTest, TenantsDoNotSeeNorEndEachOthersSessions) {
  const auto session = Open(car_, OpenOf("car-1"));
  const auto opened = session->Read();
  ASSERT_TRUE(opened.has_value());
  const std::string& id = opened->opened().session_id();
  const std::string foreign = Token({.name = "ops", .tenant = "acme", .role = Role::kAdmin});
  const auto list = [&](const std::string& token) {
    CallAs call(token);
    v1::ListSessionsResponse response;
    EXPECT_TRUE(server_.admin->ListSessions(&call, {}, &response).ok());
    return response.sessions_size();
  };
  EXPECT_EQ(list(ops_), 1);
  EXPECT_EQ(list(foreign), 0);
  CallAs get_call(foreign);
  v1::GetSessionRequest get;
  get.set_session_id(id);
  v1::GetSessionResponse got;
  EXPECT_EQ(server_.admin->GetSession(&get_call, get, &got).error_code(),
            grpc::StatusCode::NOT_FOUND);
  CallAs end_call(foreign);
  v1::EndSessionRequest end;
  end.set_session_id(id);
  v1::EndSessionResponse ended;
  EXPECT_EQ(server_.admin->EndSession(&end_call, end, &ended).error_code(),
            grpc::StatusCode::NOT_FOUND);
  CallAs watch_call(foreign);
  v1::WatchSessionRequest watch;
  watch.set_session_id(id);
  const auto watcher = server_.admin->WatchSession(&watch_call, watch);
  v1::WatchSessionResponse answer;
  EXPECT_FALSE(watcher->Read(&answer));
  EXPECT_EQ(watcher->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_TRUE(session->Localize(ScanMessage(0)).has_value());
}

TEST_F(SessionAccessTest, TenantsDoNotDriveInEachOthersMaps) {
  const std::string foreign = Token({.name = "a", .tenant = "acme", .role = Role::kOperator});
  EXPECT_EQ(Refusal(foreign, OpenOf("car-1")).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(SessionAccessTest, DenialsAreLogged) {
  std::ostringstream log;
  const auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(log);
  {
    // Of a server that is gone when the log is read.
    const auto before = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", sink));
    {
      const TestServer server;
      const auto identities = *OpenIdentities(server.folder.path() / "store");
      const std::string viewer =
          *identities->Create(Proof::kToken, {.name = "eve", .role = Role::kViewer}, {});
      CallAs call(viewer);
      v1::DeleteMapResponse response;
      EXPECT_EQ(server.maps->DeleteMap(&call, {}, &response).error_code(),
                grpc::StatusCode::PERMISSION_DENIED);
      EXPECT_THAT(log.str(), ::testing::Not(HasSubstr(viewer))) << "no secret is logged";
    }
    spdlog::set_default_logger(before);
  }
  EXPECT_THAT(log.str(), AllOf(HasSubstr("denied request=dcloc.v1.DeleteMapRequest"),
                               HasSubstr("manage_maps"), HasSubstr("eve")));
}

/// A server with narrow limits for each principal.
class NarrowTest : public SessionAccessTest {
 protected:
  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.max_session_count_per_principal = 1;
    config.max_scan_rate_hz_per_principal = 5;
    config.max_target_count = 25;
    return config;
  }
  NarrowTest() : SessionAccessTest(Config()) {}
};

TEST_F(NarrowTest, SessionsOfOnePrincipalAreBoundedWhateverTheirVehicles) {
  const auto first = Open(ops_, OpenOf("car-1"));
  ASSERT_TRUE(first->Read().has_value());
  const grpc::Status status = Refusal(ops_, OpenOf("car-2"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("max_session_count_per_principal is 1"));
  EXPECT_TRUE(Open(car_, OpenOf("car-1"))->Read().has_value()) << "another principal's";
  v1::LocalizeRequest close;
  close.mutable_close();
  ASSERT_TRUE(first->Send(close));
  EXPECT_TRUE(first->Finish().ok());
  // The thread that opened the first may have it a moment longer.
  EXPECT_TRUE(Eventually([this] { return Open(ops_, OpenOf("car-2"))->Read().has_value(); }))
      << "after the first has ended";
}

TEST_F(NarrowTest, AScanWithTooManyTargetsIsRefusedAndTheSessionGoesOn) {
  const auto session = Open(car_, OpenOf("car-1"));
  ASSERT_TRUE(session->Read().has_value());
  const auto refused = session->Localize(ScanMessage(0, 26));
  ASSERT_TRUE(refused && refused->has_rejected());
  EXPECT_EQ(refused->rejected().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(refused->rejected().message(), HasSubstr("max_target_count is 25"));
  const auto taken = session->Localize(ScanMessage(1, 25));
  EXPECT_TRUE(taken && taken->has_result());
}

TEST_F(NarrowTest, ScansThatComeTooFastAreRefusedAndTheSessionGoesOn) {
  const auto session = Open(car_, OpenOf("car-1"));
  ASSERT_TRUE(session->Read().has_value());
  int taken_count = 0;
  for (int i = 0; i < 40; ++i) {
    const auto answer = session->Localize(ScanMessage(i));
    ASSERT_TRUE(answer.has_value()) << i;
    if (answer->has_result()) {
      ++taken_count;
      continue;
    }
    EXPECT_EQ(answer->rejected().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_THAT(answer->rejected().message(),
                HasSubstr("max_scan_rate_hz_per_principal, which is 5"));
  }
  EXPECT_GE(taken_count, 5) << "a second's worth";
  EXPECT_LT(taken_count, 40);
}

/// What a server with narrow limits is told while it runs.
TEST_F(NarrowTest, EachSettingThatCanChangeHoldsAtOnce) {
  std::vector<std::string> reloadable;
  for (const ConfigField& field : ConfigFields()) {
    if (field.reloadable) reloadable.emplace_back(field.key);
  }
  // Sizes of maps: AccessTest.UploadsBeyondALimitNameIt. Streams and peers: UnopenedStreamTest.
  // Downloads: DownloadSlotsTest. Passes: PassWriterTest, which asks for the bounds of each.
  EXPECT_THAT(reloadable,
              ::testing::ElementsAre("max_session_count", "max_unopened_stream_count",
                                     "max_unopened_stream_count_per_peer", "open_timeout_ms",
                                     "peer_timeout_ms", "max_session_count_per_principal",
                                     "max_scan_rate_hz_per_principal", "max_download_count",
                                     "max_download_count_per_caller", "max_target_count",
                                     "max_map_mib", "pass_storage_mib", "pass_vehicle_mib_per_day",
                                     "pass_retention_days", "max_tenant_storage_mib", "log_level"));
  ServerConfig config = Config();
  config.data = server_.folder.path() / "store";
  config.listen = "127.0.0.1:0";
  const auto reload = [&] { ASSERT_TRUE(server_.server->Reload(config).ok()); };
  const auto session = Open(car_, OpenOf("car-1"));
  ASSERT_TRUE(session->Read().has_value());

  config.max_target_count = 26;
  reload();
  const auto wide = session->Localize(ScanMessage(0, 26));
  EXPECT_TRUE(wide && wide->has_result());

  config.max_scan_rate_hz_per_principal = 0;
  reload();
  for (int i = 1; i < 20; ++i) {
    const auto answer = session->Localize(ScanMessage(i));
    EXPECT_TRUE(answer && answer->has_result()) << i;
  }

  EXPECT_EQ(Refusal(car_, OpenOf("car-1")).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  config.max_session_count_per_principal = 2;
  reload();
  const auto second = Open(car_, OpenOf("car-1"));
  EXPECT_TRUE(second->Read().has_value());

  config.max_session_count = 2;
  reload();
  const grpc::Status full = Refusal(ops_, OpenOf("car-2"));
  EXPECT_EQ(full.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(full.error_message(), HasSubstr("2 sessions"));

  const auto level = spdlog::get_level();
  config.log_level = "error";
  reload();
  EXPECT_EQ(spdlog::get_level(), spdlog::level::err);
  spdlog::set_level(level);
}

}  // namespace
}  // namespace dcloc::server
