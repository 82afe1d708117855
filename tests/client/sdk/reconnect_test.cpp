#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/sdk/channel.h"
#include "client/sdk/map_client.h"
#include "client/sdk/session.h"
#include "server/app/server.h"
#include "spdlog/spdlog.h"
#include "tests/client/sdk/tcp_proxy.h"
#include "tests/core/map/synthetic_map.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/town_drive.h"

// The SDK and the server through a network that fails: each scan is answered exactly once, and
// where the session outlived the failure the track is the undisturbed one to the bit.
namespace dcloc::client {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// A server that a test can stop and start, behind a proxy that it can cut. Who connects to the
/// proxy finds the new server after a restart.
class Site {
 public:
  explicit Site(server::ServerConfig config) : config_(std::move(config)) {
    spdlog::set_level(spdlog::level::err);
    config_.data = (folder_.path() / "data").string();
    config_.listen = "127.0.0.1:0";
    Start();
    proxy_ = std::make_unique<TcpProxy>(Port());
  }

  void Upload(const std::vector<std::byte>& map) {
    const auto uploaded = MapClient(*MakeChannel({.server = server_->address()}))
                              .Upload(folder_.Write("map", map), "town", {.activate = true});
    ASSERT_TRUE(uploaded.ok()) << uploaded.status();
  }

  void Restart(std::chrono::milliseconds deadline = 2s) {
    server_->Shutdown(deadline);
    server_.reset();
    Start();
    proxy_->SetTarget(Port());
  }

  void Stop() { server_.reset(); }
  void Cut() { proxy_->Cut(); }
  server::Server& server() { return *server_; }
  std::shared_ptr<grpc::Channel> Channel() const {
    return *MakeChannel({.server = proxy_->address()});
  }

 private:
  void Start() {
    auto started = server::Server::Start(config_);
    ASSERT_TRUE(started.ok()) << started.status();
    server_ = *std::move(started);
  }
  int Port() const {
    const std::string address = server_->address();
    return std::stoi(address.substr(address.rfind(':') + 1));
  }

  const TemporaryFolder folder_;
  server::ServerConfig config_;
  std::unique_ptr<server::Server> server_;
  std::unique_ptr<TcpProxy> proxy_;
};

/// Counts what it is told.
class Events {
 public:
  std::function<void(const SessionEvent&)> Listener() {
    return [this](const SessionEvent& event) {
      const std::lock_guard lock(mutex_);
      ++counts_[event.kind];
      if (event.kind == SessionEvent::Kind::kRestarted) restart_reason_ = event.status;
    };
  }
  int count(SessionEvent::Kind kind) {
    const std::lock_guard lock(mutex_);
    return counts_[kind];
  }
  absl::Status restart_reason() {
    const std::lock_guard lock(mutex_);
    return restart_reason_;
  }

 private:
  std::mutex mutex_;
  std::map<SessionEvent::Kind, int> counts_;
  absl::Status restart_reason_;
};

SessionOptions Options(Events* events = nullptr) {
  SessionOptions options{.when_full = FullQueue::kBlock};
  options.reconnect =
      ReconnectOptions{.initial_backoff = 10ms, .max_backoff = 200ms, .give_up_after = 60s};
  if (events != nullptr) options.on_event = events->Listener();
  return options;
}

std::unique_ptr<Session> OpenOrDie(const Site& site, const v1::OpenSession& open,
                                   const SessionOptions& options) {
  auto session = Session::Open(site.Channel(), open, options);
  EXPECT_TRUE(session.ok()) << session.status();
  return *std::move(session);
}

/// An answer without what a clock gives.
std::string Essence(v1::LocalizeResponse answer) {
  answer.clear_from_memory();
  if (answer.has_result()) answer.mutable_result()->clear_timings();
  return answer.SerializeAsString();
}

/// Sends all scans, and gives the answers: one to each, in order, or the test fails.
std::vector<v1::LocalizeResponse> Drive(Session& session, const std::vector<v1::Scan>& scans,
                                        std::atomic<int>* progress = nullptr) {
  std::thread sender([&] {
    for (const v1::Scan& scan : scans) {
      if (!session.Send(scan).ok()) return;
    }
    session.CloseSending();
  });
  std::vector<v1::LocalizeResponse> answers;
  while (auto answer = session.Next()) {
    const std::int64_t number = answer->has_result() ? answer->result().sequence_number()
                                                     : answer->rejected().sequence_number();
    EXPECT_EQ(number, scans[answers.size()].sequence_number());
    answers.push_back(*std::move(answer));
    if (progress != nullptr) ++*progress;
    if (answers.size() > scans.size()) break;
  }
  EXPECT_TRUE(session.EndStatus().ok()) << session.EndStatus();
  EXPECT_EQ(answers.size(), scans.size());
  session.Cancel();
  sender.join();
  return answers;
}

/// Cuts the site each time that the progress has grown by so much, give or take half.
class Saboteur {
 public:
  Saboteur(Site& site, std::atomic<int>& progress, int cut_count, int interval)
      : thread_([&site, &progress, cut_count, interval](const std::stop_token& stop) {
          std::mt19937 random(7);
          std::uniform_int_distribution<int> step(interval / 2, interval + interval / 2);
          int next = step(random);
          for (int cut = 0; cut < cut_count && !stop.stop_requested();) {
            if (progress >= next) {
              site.Cut();
              next += step(random);
              ++cut;
            }
            std::this_thread::sleep_for(1ms);
          }
        }) {}

 private:
  std::jthread thread_;
};

std::vector<v1::Scan> StraightDrive(int count) {
  std::vector<v1::Scan> scans;
  for (int i = 0; i < count; ++i) {
    scans.push_back(server::ScanMessage(i));
    if (i % 97 == 5) scans.back().set_radar_id("nobody");  // rejected, which is an answer as well
  }
  return scans;
}

server::ServerConfig StubConfig() {
  server::ServerConfig config;
  config.stub_localizer = true;
  return config;
}

/// A server with the stub localizer and a small map.
class ReconnectTest : public ::testing::Test {
 protected:
  explicit ReconnectTest(const server::ServerConfig& config = StubConfig()) : site_(config) {
    site_.Upload(SyntheticMap(12, 20).Bytes());
  }
  Site site_;
  Events events_;
};

TEST_F(ReconnectTest, TenThousandScansThroughFiftyCutsAreTheUndisturbedTrack) {
  const std::vector<v1::Scan> scans = StraightDrive(10'000);
  const auto undisturbed = OpenOrDie(site_, server::OpenMessage(), Options());
  const std::vector<v1::LocalizeResponse> expected = Drive(*undisturbed, scans);

  const auto session = OpenOrDie(site_, server::OpenMessage(), Options(&events_));
  std::atomic<int> progress = 0;
  std::vector<v1::LocalizeResponse> answers;
  {
    const Saboteur saboteur(site_, progress, 50, 180);
    answers = Drive(*session, scans, &progress);
  }
  ASSERT_EQ(answers.size(), expected.size());
  for (std::size_t i = 0; i < answers.size(); ++i) {
    ASSERT_EQ(Essence(answers[i]), Essence(expected[i])) << i;
  }
  const SessionStats stats = session->stats();
  EXPECT_EQ(stats.restart_count, 0);
  EXPECT_GE(stats.resume_count, 25) << "some cuts hit a connection that is being made";
  EXPECT_EQ(stats.resume_count, events_.count(SessionEvent::Kind::kResumed));
}

TEST_F(ReconnectTest, CutsAndRestartsLeaveEachScanWithOneAnswer) {
  const int restarts = 3;
  const std::vector<v1::Scan> scans = StraightDrive(2'000);
  const auto session = OpenOrDie(site_, server::OpenMessage(), Options(&events_));
  std::atomic<int> progress = 0;
  std::vector<v1::LocalizeResponse> answers;
  {
    const std::jthread operations([&] {
      for (int i = 1; i <= restarts; ++i) {
        while (progress < 500 * i) std::this_thread::sleep_for(1ms);
        if (i % 2 == 0) site_.Cut();
        site_.Restart();
      }
    });
    answers = Drive(*session, scans, &progress);
  }
  EXPECT_EQ(session->stats().restart_count, restarts);
  EXPECT_THAT(std::string(events_.restart_reason().message()), HasSubstr("restarted"));
  // The stub integrates from the prior, so the track goes on, but for the motion at each seam.
  const double way_m = 0.77 * static_cast<double>(scans.size());
  EXPECT_NEAR(answers.back().result().pose().pose().translation_m().x(), way_m,
              2.0 + 2.0 * restarts);
}

TEST_F(ReconnectTest, ADrainIsAnnouncedAndTheSessionMovesToTheNextServer) {
  const std::vector<v1::Scan> scans = StraightDrive(600);
  const auto session = OpenOrDie(site_, server::OpenMessage(), Options(&events_));
  std::atomic<int> progress = 0;
  {
    const std::jthread operations([&] {
      while (progress < 200) std::this_thread::sleep_for(1ms);
      site_.Restart(10s);
    });
    Drive(*session, scans, &progress);
  }
  EXPECT_EQ(events_.count(SessionEvent::Kind::kMoving), 1);
  EXPECT_EQ(events_.count(SessionEvent::Kind::kRestarted), 1);
}

TEST_F(ReconnectTest, AServerThatStaysAwayEndsTheSession) {
  SessionOptions options = Options(&events_);
  options.reconnect->give_up_after = 300ms;
  const auto session = OpenOrDie(site_, server::OpenMessage(), options);
  site_.Stop();
  EXPECT_FALSE(session->Next().has_value());
  const absl::Status status = session->EndStatus();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("gave up after 300 ms"));
}

TEST_F(ReconnectTest, CancellingDoesNotWaitForAServerThatIsAway) {
  const auto session = OpenOrDie(site_, server::OpenMessage(), Options());
  site_.Stop();
  std::this_thread::sleep_for(50ms);
  const auto begin = std::chrono::steady_clock::now();
  session->Cancel();
  EXPECT_FALSE(session->Next().has_value());
  EXPECT_TRUE(absl::IsCancelled(session->EndStatus())) << session->EndStatus();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
}

class ImpatientServerTest : public ReconnectTest {
 protected:
  static server::ServerConfig Config() {
    server::ServerConfig config = StubConfig();
    config.session_detached_timeout_ms = 0;
    return config;
  }
  ImpatientServerTest() : ReconnectTest(Config()) {}
};

TEST_F(ImpatientServerTest, AReapedSessionBeginsAnewAndSaysWhy) {
  SessionOptions options = Options(&events_);
  options.reconnect->initial_backoff = 1s;  // long enough for the server to reap it
  options.reconnect->max_backoff = 1s;
  const auto session = OpenOrDie(site_, server::OpenMessage(), options);
  ASSERT_TRUE(session->Send(server::ScanMessage(0)).ok());
  ASSERT_TRUE(session->Next()->has_result());
  ASSERT_TRUE(session->Send(server::ScanMessage(1)).ok());
  const double before = session->Next()->result().pose().pose().translation_m().x();
  site_.Cut();
  std::this_thread::sleep_for(50ms);
  ASSERT_TRUE(session->Send(server::ScanMessage(2)).ok());
  const auto answer = session->Next();
  ASSERT_TRUE(answer.has_value()) << session->EndStatus();
  EXPECT_EQ(answer->result().pose().pose().translation_m().x(), before) << "the prior";
  EXPECT_EQ(events_.count(SessionEvent::Kind::kRestarted), 1);
  EXPECT_THAT(std::string(events_.restart_reason().message()), HasSubstr("without a stream"));
}

TEST(ReconnectWithTheMethodTest, CutsDoNotChangeTheTrack) {
  const server::TownDrive town;
  const std::vector<v1::Scan> scans = town.Scans();
  Site site({});
  site.Upload(town.map);
  const auto undisturbed = OpenOrDie(site, town.Open(), Options());
  const std::vector<v1::LocalizeResponse> expected = Drive(*undisturbed, scans);
  const auto session = OpenOrDie(site, town.Open(), Options());
  std::atomic<int> progress = 0;
  std::vector<v1::LocalizeResponse> answers;
  {
    const Saboteur saboteur(site, progress, 10, 15);
    answers = Drive(*session, scans, &progress);
  }
  ASSERT_EQ(answers.size(), expected.size());
  for (std::size_t i = 0; i < answers.size(); ++i) {
    ASSERT_EQ(Essence(answers[i]), Essence(expected[i])) << i;
  }
  // A cut that falls into a reconnection makes no resumption of its own.
  EXPECT_GE(session->stats().resume_count, 1);
  EXPECT_EQ(answers.back().result().state(), v1::LOCALIZATION_STATE_TRACKING);
}

}  // namespace
}  // namespace dcloc::client
