#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "client/sdk/channel.h"
#include "client/sdk/map_client.h"
#include "client/sdk/session.h"
#include "server/app/server.h"
#include "spdlog/spdlog.h"
#include "tests/client/sdk/name_server.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_maps.h"

// The SDK while the name of its server cannot be resolved: who is connected goes on, and who is not
// is back within five seconds of the name.
namespace dcloc::client {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Mood = NameServer::Mood;

constexpr auto kRecovery = 5s;
// Of a name that was asked for in vain, and has another address: more than the five seconds aimed
// at.
constexpr auto kSilentRecovery = 8s;

class NameTest : public ::testing::TestWithParam<Mood> {
 protected:
  NameTest() {
    spdlog::set_level(spdlog::level::err);
    Start("127.0.0.1:0");
    port_ = std::stoi(server_->address().substr(server_->address().rfind(':') + 1));
    const auto uploaded =
        MapClient(*MakeChannel({.server = server_->address()}))
            .Upload(folder_.Write("map", server::SmallMap()), "town", {.activate = true});
    EXPECT_TRUE(uploaded.ok()) << uploaded.status();
  }

  void Start(const std::string& listen) {
    server::ServerConfig config;
    config.data = (folder_.path() / "data").string();
    config.listen = listen;
    config.stub_localizer = true;
    auto started = server::Server::Start(config);
    ASSERT_TRUE(started.ok()) << started.status();
    server_ = *std::move(started);
  }

  std::shared_ptr<grpc::Channel> Channel() const {
    return *MakeChannel({.server = names_.Target(port_), .own_connection = true});
  }

  /// Whether a scan is answered within the time of a recovery.
  static bool Answers(Session& session, std::int64_t number,
                      std::chrono::seconds bound = kRecovery) {
    const Clock::time_point begin = Clock::now();
    EXPECT_TRUE(session.Send(server::ScanMessage(number)).ok());
    const auto answer = session.Next();
    return answer && answer->result().sequence_number() == number && Clock::now() - begin < bound;
  }

  const TemporaryFolder folder_;
  NameServer names_;
  std::unique_ptr<server::Server> server_;
  int port_ = 0;
};

TEST_P(NameTest, WhoIsConnectedGoesOnAndIsBackAtItsServerWithoutIt) {
  const auto session = Session::Open(Channel(), server::OpenMessage());
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_TRUE(Answers(**session, 0));
  names_.SetMood(GetParam());
  EXPECT_TRUE(Answers(**session, 1));
  server_.reset();
  Start("127.0.0.1:" + std::to_string(port_));
  EXPECT_TRUE(Answers(**session, 2)) << "it knows the address";
}

TEST_P(NameTest, ANameThatComesBackWithAnotherAddressIsFound) {
  const auto session = Session::Open(Channel(), server::OpenMessage());
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_TRUE(Answers(**session, 0));
  names_.SetMood(GetParam());
  server_.reset();
  Start("127.0.0.2:" + std::to_string(port_));
  std::this_thread::sleep_for(3s);
  names_.SetAddress(2);
  names_.SetMood(Mood::kAnswers);
  EXPECT_TRUE(Answers(**session, 1, GetParam() == Mood::kSilent ? kSilentRecovery : kRecovery));
  EXPECT_EQ((*session)->stats().restart_count, 1);
}

// gRPC alone would look again after some 9 and 16 s, and then more and more rarely.
TEST_P(NameTest, WhoOpensIsRefusedUntilTheNameIsBack) {
  names_.SetMood(GetParam());
  const auto channel = Channel();
  const Clock::time_point begin = Clock::now();
  while (Clock::now() - begin < 10s) {
    const absl::Status status =
        Session::Open(channel, server::OpenMessage(), {.open_timeout = 3s}).status();
    ASSERT_TRUE(absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status)) << status;
    std::this_thread::sleep_for(1500ms);
  }
  names_.SetMood(Mood::kAnswers);
  const Clock::time_point back = Clock::now();
  while (!Session::Open(channel, server::OpenMessage(), {.open_timeout = 3s}).ok()) {
    ASSERT_LT(Clock::now() - back, kSilentRecovery);
    std::this_thread::sleep_for(1500ms);
  }
  EXPECT_GT(names_.question_count(), 3);
}

INSTANTIATE_TEST_SUITE_P(WithoutNames, NameTest, ::testing::Values(Mood::kFails, Mood::kSilent),
                         [](const auto& mood) {
                           return mood.param == Mood::kFails ? "Failing" : "Silent";
                         });

}  // namespace
}  // namespace dcloc::client
