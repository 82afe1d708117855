#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "client/cli/remote/answer_text.h"
#include "client/sdk/admin_client.h"
#include "tests/client/cli/dcloc_process.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

// `dcloc session` and `dcloc server`, against the server as it is shipped.
namespace dcloc::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class AdminCommandsTest : public ::testing::Test {
 protected:
  AdminCommandsTest() {
    const std::vector<std::byte> map = server::SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(server::UploadMap(*server_.maps, server::HeaderOf(map), map, &response).ok());
  }

  std::unique_ptr<server::TestSession> OpenSession(const std::string& vehicle_id) {
    auto session = std::make_unique<server::TestSession>(*server_.localization);
    v1::OpenSession open = server::OpenMessage();
    open.set_vehicle_id(vehicle_id);
    EXPECT_TRUE(session->Open(open));
    const auto opened = session->Read();
    EXPECT_TRUE(opened.has_value());
    if (opened) ids_.push_back(opened->opened().session_id());
    return session;
  }

  std::string At(const std::string& words) const {
    return words + " --server " + server_.server->address() + " ";
  }

  server::TestServer server_;
  std::vector<std::string> ids_;
};

TEST_F(AdminCommandsTest, SessionsAreListedAndShown) {
  const auto first = OpenSession("car-1");
  const auto second = OpenSession("car-2");
  ASSERT_TRUE(second->Localize(server::ScanMessage(4))->has_result());
  const json all = json::parse(Dcloc(At("session list") + "--json").out);
  EXPECT_EQ(all.size(), 2U);
  const json one = json::parse(Dcloc(At("session list") + "--vehicle car-2 --json").out);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0]["session_id"], ids_[1]);
  EXPECT_EQ(one[0]["scan_count"], 1);
  EXPECT_EQ(one[0]["last_sequence_number"], 4);
  EXPECT_EQ(one[0]["state"], "dead_reckoning");
  const Result table = Dcloc(At("session list"));
  EXPECT_THAT(table.out, AllOf(HasSubstr("car-1"), HasSubstr("car-2"), HasSubstr("town:1"),
                               HasSubstr("dead_reckoning"), HasSubstr(ids_[0].substr(0, 8))));
  for (const std::string& name : {ids_[1], ids_[1].substr(0, 10), std::string("car-2")}) {
    const Result shown = Dcloc(At("session show") + name + " --json");
    ASSERT_EQ(shown.exit_code, 0) << shown.err;
    EXPECT_EQ(json::parse(shown.out)["session_id"], ids_[1]);
  }
  EXPECT_THAT(Dcloc(At("session show") + "car-2").out, HasSubstr(ids_[1]));
}

TEST_F(AdminCommandsTest, ANameThatIsNotOneSessionsIsAnError) {
  const auto first = OpenSession("car-1");
  const auto second = OpenSession("car-1");
  const Result two = Dcloc(At("session show") + "car-1");
  EXPECT_EQ(two.exit_code, 1);
  EXPECT_THAT(two.err, AllOf(HasSubstr(ids_[0]), HasSubstr(ids_[1])));
  const Result none = Dcloc(At("session end") + "car-7");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("car-7"));
  EXPECT_EQ(Dcloc(At("session show")).exit_code, 2);
}

TEST_F(AdminCommandsTest, AnswersAreWatched) {
  const auto session = OpenSession("car-1");
  DclocProcess watch(At("session watch") + "car-1 --json --count 2");
  // Until the watcher is there, answers pass it by.
  for (int i = 0; !watch.HasEnded(); ++i) {
    ASSERT_TRUE(session->Localize(server::ScanMessage(i)).has_value());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const Result result = watch.Wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  const json first = json::parse(line);
  EXPECT_EQ(first["state"], "dead_reckoning");
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(json::parse(line)["sequence_number"], first["sequence_number"].get<int>() + 1);
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(AdminCommandsTest, CtrlCEndsAWatchWell) {
  const auto session = OpenSession("car-1");
  DclocProcess watch(At("session watch") + "car-1");
  for (int i = 0; watch.Out().empty(); ++i) {
    ASSERT_TRUE(session->Localize(server::ScanMessage(i)).has_value());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  watch.Signal(SIGINT);
  const Result result = watch.Wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("dead_reckoning"));
}

TEST_F(AdminCommandsTest, ASessionIsEndedWithAReason) {
  const auto session = OpenSession("car-1");
  const Result result = Dcloc(At("session end") + "car-1 --reason \"radar misaligned\"");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const grpc::Status status = session->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_THAT(status.error_message(), HasSubstr("radar misaligned"));
  const Result gone = Dcloc(At("session show") + ids_[0]);
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_THAT(gone.err, HasSubstr("radar misaligned")) << "why it ended is still known";
}

TEST_F(AdminCommandsTest, TheServerSaysHowItDoesAndIsDrained) {
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

TEST_F(AdminCommandsTest, ADrainThatTakesTooLongIsAnError) {
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

TEST_F(AdminCommandsTest, WithoutAServerTheErrorNamesIt) {
  for (const char* command : {"session list", "session show x", "server status", "server drain"}) {
    const Result result = Dcloc(std::string(command) + " --server 127.0.0.1:1");
    EXPECT_EQ(result.exit_code, 1) << command;
    EXPECT_THAT(result.err, HasSubstr("127.0.0.1:1")) << command;
  }
}

TEST(AgeTextTest, HasAFittingUnit) {
  EXPECT_EQ(AgeText(0.25), "250 ms");
  EXPECT_EQ(AgeText(30.0), "30 s");
  EXPECT_EQ(AgeText(600.0), "10 min");
  EXPECT_EQ(AgeText(36000.0), "10 h");
}

}  // namespace
}  // namespace dcloc::cli
