#include "client/load/load_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "client/load/load_report.h"
#include "client/sdk/channel.h"
#include "tests/client/sdk/fake_server.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::load {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Lt;

/// A street of a minute, at 13 Hz.
Route Street(const std::string& map = "town") {
  Route route{.name = "street", .scans = {}, .true_positions_m = {}, .open = {}};
  for (int i = 0; i < 800; ++i) {
    route.scans.push_back(server::ScanMessage(i));
    route.true_positions_m.emplace_back(0.77 * i, 0.0);
  }
  route.open = [map](std::size_t /*first*/, std::uint64_t /*seed*/) {
    v1::OpenSession open = server::OpenMessage();
    open.set_map_name(map);
    return open;
  };
  return route;
}

LoadOptions Short(int vehicle_count = 10) {
  return {.vehicle_count = vehicle_count,
          .duration = 2000ms,
          .warmup = 200ms,
          .ramp = 300ms,
          .drain = 5000ms};
}

/// The load against the server as it is shipped, with its matcher that only integrates.
class LoadRunTest : public ::testing::Test {
 protected:
  LoadRunTest() {
    v1::UploadMapResponse response;
    const std::vector<std::byte> map = server::SmallMap();
    EXPECT_TRUE(server::UploadMap(*server_.maps, server::HeaderOf(map), map, &response).ok());
  }

  absl::StatusOr<LoadResult> Run(const LoadOptions& options, const Route& route = Street(),
                                 const LoadObserver& observer = {}) const {
    return RunLoad(
        options, {route},
        [&] {
          return MakeLink({.server = server_.server->address()},
                          options.faults.disconnects_per_min > 0.0);
        },
        observer);
  }

  server::TestServer server_;
};

TEST_F(LoadRunTest, EachScanIsAnsweredAtItsPace) {
  const auto result = Run(Short());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_THAT(Shortfalls(*result, 0.0), ElementsAre());
  const LoadTotals& totals = result->record.totals;
  EXPECT_GE(totals.opened_count, 10);
  EXPECT_NEAR(result->RateHz(), 10 * 13.0, 20.0);
  EXPECT_EQ(totals.judged_count, 0) << "the stub claims no pose";
  EXPECT_EQ(result->record.latency.count(), totals.answered_count);
  EXPECT_GE(result->record.seconds.size(), 1U);
  EXPECT_GT(result->client_core_count, 0.0);
  const auto json = ToJson(*result, {});
  EXPECT_EQ(json["totals"]["lost_count"], 0);
  EXPECT_EQ(json["held"], true);
}

TEST_F(LoadRunTest, TheClosedLoopIsFasterThanTheRecording) {
  LoadOptions options = Short(2);
  options.open_loop = false;
  const auto result = Run(options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_THAT(Shortfalls(*result, 0.0), ElementsAre());
  EXPECT_GT(result->RateHz(), 4 * 2 * 13.0);
  EXPECT_GT(result->record.totals.opened_count, 2) << "the route is driven again and again";
}

TEST_F(LoadRunTest, FaultsAreBorneAndNothingIsLost) {
  LoadOptions options = Short(20);
  options.duration = 4000ms;
  options.faults = {.disconnects_per_min = 60.0,
                    .stalls_per_min = 30.0,
                    .stall_duration = 200ms,
                    .slow_reader_share = 0.2,
                    .slow_read_interval = 100ms,
                    .duplicate_share = 0.1,
                    .reorder_share = 0.1};
  const auto result = Run(options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_THAT(Shortfalls(*result, 0.0), ElementsAre());
  const LoadTotals& totals = result->record.totals;
  EXPECT_GT(totals.disconnect_count, 20);
  EXPECT_GT(totals.stall_count, 10);
  EXPECT_GT(totals.repeated_count, 20);
  EXPECT_GT(totals.late_refused_count, 20);
  EXPECT_LT(totals.opened_count, 20 + totals.disconnect_count / 4)
      << "sessions are resumed, and opened anew only at the end of the route";
}

// gRPC may begin a stream on a connection that breaks just then. Such a one must fail, and not be
// open but deaf until the next break.
TEST_F(LoadRunTest, WhoReturnsAtOnceIsHeard) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitized server does not keep up with a hundred vehicles";
#endif
  LoadOptions options = Short(100);
  options.duration = 4000ms;
  options.drain = 2000ms;
  options.faults = {.disconnects_per_min = 60.0};
  const auto result = Run(options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_THAT(Shortfalls(*result, 0.0), ElementsAre());
  EXPECT_GT(result->record.totals.disconnect_count, 200);
}

TEST_F(LoadRunTest, SessionsThatAreMovedToAnotherVersionBreakNoContract) {
  v1::UploadMapResponse response;
  const std::vector<std::byte> next = server::SmallMap("next");
  v1::UploadMapHeader header = server::HeaderOf(next);
  header.set_activate(false);
  ASSERT_TRUE(server::UploadMap(*server_.maps, header, next, &response).ok());
  LoadOptions options = Short(4);
  options.faults = {.disconnects_per_min = 60.0};
  bool activated = false;
  const auto activate = [&](const LoadSecond& second) {
    if (second.time_s == 0.0 || activated) return;
    activated = true;
    server::Call call;
    v1::ActivateMapVersionRequest request;
    request.set_map_name("town");
    request.set_version(2);
    request.set_move_sessions(true);
    v1::ActivateMapVersionResponse moved;
    EXPECT_TRUE(server_.maps->ActivateMapVersion(&call, request, &moved).ok());
  };
  const auto result = Run(options, Street(), {.on_second = activate, .stopped = {}});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(activated);
  EXPECT_THAT(Shortfalls(*result, 0.0), ElementsAre());
  EXPECT_EQ(result->record.totals.moved_count, 4);
}

TEST_F(LoadRunTest, VehiclesBeginInTheGivenShareOfTheirDrive) {
  const auto latest_of = [this](double begin_within) {
    Route route = Street();
    std::atomic<std::size_t> latest = 0;
    route.open = [&latest, open = route.open](std::size_t first, std::uint64_t seed) {
      latest = std::max(latest.load(), first);
      return open(first, seed);
    };
    LoadOptions options = Short(20);
    options.duration = 300ms;
    options.begin_within = begin_within;
    EXPECT_TRUE(Run(options, route).ok());
    return latest.load();
  };
  EXPECT_EQ(latest_of(0.0), 0);
  EXPECT_THAT(latest_of(0.25), AllOf(Gt(100), Lt(200)));
  EXPECT_GT(latest_of(1.0), 600);
}

TEST_F(LoadRunTest, ATargetThatIsMissedIsSaid) {
  const auto result = Run(Short(2));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_THAT(Shortfalls(*result, 1e-3), ElementsAre(HasSubstr("the target is 0.001 ms")));
}

TEST_F(LoadRunTest, SessionsThatCannotBeOpenedAreAnError) {
  const absl::Status status = Run(Short(2), Street("nowhere")).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("nowhere"));
}

TEST_F(LoadRunTest, ItCanBeStopped) {
  LoadOptions options = Short(2);
  options.duration = std::chrono::hours(1);
  const auto begin = std::chrono::steady_clock::now();
  const auto result = Run(
      options, Street(),
      {.on_second = {}, .stopped = [&] { return std::chrono::steady_clock::now() - begin > 2s; }});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(result->measured_s, 10.0);
  EXPECT_EQ(
      Run(options, Street(), {.on_second = {}, .stopped = [] { return true; }}).status().code(),
      absl::StatusCode::kCancelled);
}

TEST_F(LoadRunTest, RoutesWithoutScansAreRefused) {
  Route empty = Street();
  empty.scans.clear();
  EXPECT_EQ(Run(Short(), empty).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(RunLoad(Short(), {}, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

/// What a server says is not believed.
std::vector<std::string> ShortfallsAgainst(const client::FakeServer::Behaviour& behaviour) {
  const client::FakeServer server(behaviour);
  LoadOptions options = Short(1);
  options.drain = 500ms;
  const auto result = RunLoad(options, {Street()}, [&]() -> absl::StatusOr<VehicleLink> {
    return VehicleLink{server.Channel(), {}};
  });
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? Shortfalls(*result, 0.0) : std::vector<std::string>();
}

TEST(LoadAgainstABadServerTest, WrongAnswersAreSeen) {
  EXPECT_THAT(
      ShortfallsAgainst([](grpc::ServerContext&, client::LocalizeServerStream& stream) {
        client::AcceptOpen(stream);
        v1::LocalizeRequest request;
        while (stream.Read(&request)) {
          v1::LocalizeResponse response;
          response.mutable_result()->set_sequence_number(request.scan().sequence_number() + 1);
          stream.Write(response);
        }
        return grpc::Status::OK;
      }),
      Contains(HasSubstr("was due")));
}

TEST(LoadAgainstABadServerTest, UnansweredScansAreLost) {
  EXPECT_THAT(ShortfallsAgainst([](grpc::ServerContext&, client::LocalizeServerStream& stream) {
                client::AcceptOpen(stream);
                v1::LocalizeRequest request;
                while (stream.Read(&request)) {
                }
                return grpc::Status::OK;
              }),
              Contains(HasSubstr("scans were lost")));
}

/// A server that loses its first session after five answers, and each of whose poses is at x = 7 m.
class ForgetfulServer {
 public:
  grpc::Status Localize(client::LocalizeServerStream& stream) {
    v1::LocalizeRequest request;
    stream.Read(&request);
    if (!request.open().resume_token().empty()) return {grpc::StatusCode::NOT_FOUND, "gone"};
    const bool is_first = open_count_++ == 0;
    if (!is_first) prior_x_m_ = request.open().initial_pose().pose().translation_m().x();
    v1::LocalizeResponse response;
    response.mutable_opened()->set_resume_token("token");
    response.mutable_opened()->set_map_version(1);
    stream.Write(response);
    for (int count = 0; stream.Read(&request) && request.has_scan(); ++count) {
      if (is_first && count == 5) return {grpc::StatusCode::UNAVAILABLE, "killed"};
      stream.Write(AnswerTo(request.scan()));
    }
    return grpc::Status::OK;
  }

  int open_count() const { return open_count_; }
  double prior_x_m() const { return prior_x_m_; }

 private:
  static v1::LocalizeResponse AnswerTo(const v1::Scan& scan) {
    v1::LocalizeResponse response;
    v1::LocalizationResult& result = *response.mutable_result();
    result.set_sequence_number(scan.sequence_number());
    result.set_stamp_ns(scan.stamp_ns());
    result.set_map_version(1);
    result.set_state(v1::LOCALIZATION_STATE_LOST);
    result.mutable_pose()->mutable_pose()->mutable_translation_m()->set_x(7.0);
    result.mutable_pose()->mutable_pose()->mutable_rotation()->set_w(1.0);
    for (int i = 0; i < 36; ++i) result.mutable_pose()->add_covariance(i % 7 == 0 ? 1.0 : 0.0);
    return response;
  }

  std::atomic<int> open_count_ = 0;
  std::atomic<double> prior_x_m_ = 0.0;
};

TEST(LoadAgainstABadServerTest, ASessionThatIsGoneBeginsAnewFromTheLastPose) {
  ForgetfulServer forgetful;
  const client::FakeServer server([&](grpc::ServerContext&, client::LocalizeServerStream& stream) {
    return forgetful.Localize(stream);
  });
  LoadOptions options = Short(1);
  options.ramp = options.warmup = 0ms;
  const auto result = RunLoad(options, {Street()}, [&]() -> absl::StatusOr<VehicleLink> {
    return VehicleLink{server.Channel(), {}};
  });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_THAT(Shortfalls(*result, 0.0), ElementsAre(HasSubstr("1 streams broke")));
  EXPECT_EQ(forgetful.open_count(), 2);
  EXPECT_EQ(forgetful.prior_x_m(), 7.0);
  const LoadRecord& record = result->record;
  EXPECT_EQ(record.totals.restart_count, 1);
  EXPECT_EQ(record.totals.opened_count, 1);
  EXPECT_EQ(record.totals.lost_state_count, record.totals.answered_count);
  EXPECT_GE(record.gap.max_ms(), 100.0) << "the vehicle waits before it tries again";
  EXPECT_LT(record.gap.max_ms(), 1500.0);
}

TEST(LoadAgainstABadServerTest, TimeWithoutAnAnswerCountsToTheEnd) {
  const client::FakeServer server([](grpc::ServerContext&, client::LocalizeServerStream& stream) {
    client::AcceptOpen(stream);
    v1::LocalizeRequest request;
    stream.Read(&request);
    v1::LocalizeResponse response;
    response.mutable_result()->set_sequence_number(request.scan().sequence_number());
    stream.Write(response);
    while (stream.Read(&request)) {
    }
    return grpc::Status::OK;
  });
  LoadOptions options = Short(1);
  options.drain = 100ms;
  const auto result = RunLoad(options, {Street()}, [&]() -> absl::StatusOr<VehicleLink> {
    return VehicleLink{server.Channel(), {}};
  });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_GE(result->record.gap.max_ms(), 500.0) << "no later answer ends it";
}

}  // namespace
}  // namespace dcloc::load
