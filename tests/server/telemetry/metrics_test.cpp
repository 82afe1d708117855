#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <sstream>
#include <string>
#include <vector>

#include "server/telemetry/metrics_endpoint.h"
#include "spdlog/sinks/ostream_sink.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// What a server on 127.0.0.1 says to `request`; what it says by itself at the end of its patience
/// when that is empty.
std::string Ask(const std::string& address, const std::string& request) {
  const int socket_fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in target{};
  target.sin_family = AF_INET;
  target.sin_port =
      htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  inet_pton(AF_INET, "127.0.0.1", &target.sin_addr);
  EXPECT_EQ(connect(socket_fd, reinterpret_cast<const sockaddr*>(&target), sizeof(target)), 0);
  EXPECT_EQ(send(socket_fd, request.data(), request.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(request.size()));
  std::string response;
  std::array<char, 4096> buffer{};
  for (ssize_t size = 0; (size = recv(socket_fd, buffer.data(), buffer.size(), 0)) > 0;) {
    response.append(buffer.data(), static_cast<std::size_t>(size));
  }
  close(socket_fd);
  return response;
}

std::string Get(const std::string& address, const std::string& path) {
  return Ask(address, "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
}

/// The value of `series` as Prometheus' text has it; -1 when it is not there.
double ValueOf(const std::string& text, const std::string& series) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(series + " ", 0) == 0) return std::stod(line.substr(series.size() + 1));
  }
  return -1.0;
}

class MetricsTest : public ::testing::Test {
 protected:
  MetricsTest() : server_(Config()) {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  }

  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.metrics_listen = "0";
    return config;
  }

  std::string Scrape() const { return Get(server_.server->metrics_address(), "/metrics"); }
  double Value(const std::string& series) const { return ValueOf(Scrape(), series); }

  TestServer server_;
};

TEST_F(MetricsTest, TheStateOfTheMapFilesIsTold) {
  EXPECT_GT(Value("dcloc_map_scrub_last_pass_seconds"), 1.7e9);
  EXPECT_EQ(Value("dcloc_map_files_damaged"), 0.0);
  EXPECT_EQ(Value("dcloc_map_files_quarantined"), 0.0);
  EXPECT_GE(Value("dcloc_map_scrub_bytes_total"), 0.0);
}

TEST_F(MetricsTest, ScansSessionsAndMapsAreCounted) {
  EXPECT_EQ(Value("dcloc_scan_seconds_count"), 0.0);
  EXPECT_EQ(Value("dcloc_maps_loaded"), 0.0);
  EXPECT_EQ(Value("dcloc_scans_rejected_total{reason=\"late\"}"), 0.0);
  TestSession session(*server_.localization);
  v1::OpenSession open = OpenMessage();
  open.set_resumable(true);
  ASSERT_TRUE(session.Open(open));
  ASSERT_TRUE(session.Read().has_value());
  EXPECT_EQ(Value("dcloc_sessions{stream=\"attached\",state=\"none\"}"), 1.0);
  for (int i = 5; i < 8; ++i) ASSERT_TRUE(session.Localize(ScanMessage(i))->has_result());
  ASSERT_TRUE(session.Localize(ScanMessage(7))->from_memory());
  ASSERT_TRUE(session.Localize(ScanMessage(2))->has_rejected());
  v1::Scan malformed;
  malformed.set_sequence_number(9);
  ASSERT_TRUE(session.Localize(malformed)->has_rejected());

  const std::string text = Scrape();
  EXPECT_THAT(text, HasSubstr("HTTP/1.1 200"));
  EXPECT_EQ(ValueOf(text, "dcloc_scan_seconds_count"), 3.0);
  EXPECT_EQ(ValueOf(text, "dcloc_scan_seconds_bucket{le=\"+Inf\"}"), 3.0);
  EXPECT_GT(ValueOf(text, "dcloc_scan_seconds_sum"), 0.0);
  for (const char* stage : {"queue", "conversion", "encoding"}) {
    EXPECT_EQ(ValueOf(text, std::string("dcloc_scan_stage_seconds_count{stage=\"") + stage + "\"}"),
              3.0)
        << stage;
  }
  EXPECT_EQ(ValueOf(text, "dcloc_scan_stage_seconds_count{stage=\"registration\"}"), 0.0)
      << "the stub has none";
  EXPECT_EQ(ValueOf(text, "dcloc_answers_total{state=\"dead_reckoning\"}"), 3.0);
  EXPECT_EQ(ValueOf(text, "dcloc_scans_rejected_total{reason=\"late\"}"), 1.0);
  EXPECT_EQ(ValueOf(text, "dcloc_scans_rejected_total{reason=\"invalid\"}"), 1.0);
  EXPECT_EQ(ValueOf(text, "dcloc_scans_repeated_total"), 1.0);
  EXPECT_EQ(ValueOf(text, "dcloc_session_opens_total{code=\"ok\",resumed=\"false\"}"), 1.0);
  EXPECT_EQ(ValueOf(text, "dcloc_sessions{stream=\"attached\",state=\"dead_reckoning\"}"), 1.0);
  EXPECT_EQ(ValueOf(text, "dcloc_maps_loaded"), 1.0);
  EXPECT_EQ(ValueOf(text, "dcloc_map_acquire_seconds_count"), 1.0);
  EXPECT_EQ(ValueOf(text, "dcloc_map_acquires_total{in_memory=\"false\"}"), 1.0);
  EXPECT_EQ(ValueOf(text, "dcloc_map_acquires_total{in_memory=\"true\"}"), 0.0);
  TestSession second(*server_.localization);
  ASSERT_TRUE(second.Open(OpenMessage()));
  ASSERT_TRUE(second.Read().has_value());
  EXPECT_EQ(Value("dcloc_map_acquires_total{in_memory=\"true\"}"), 1.0);
  EXPECT_GT(ValueOf(text, "dcloc_workers"), 0.0);
  EXPECT_GE(ValueOf(text, "dcloc_queue_depth{pool=\"localization\"}"), 0.0);
  EXPECT_GT(ValueOf(text, "process_open_fds"), 3.0);
  EXPECT_GT(ValueOf(text, "process_cpu_seconds_total"), 0.0);
  EXPECT_THAT(text, Not(HasSubstr("car-1"))) << "no vehicle is named";

  session.Cancel();
  EXPECT_TRUE(Eventually([&] {
    return Value("dcloc_sessions{stream=\"detached\",state=\"dead_reckoning\"}") == 1.0;
  }));
}

/// What a server logs of a scan with this number, at a level.
std::string LogOf(spdlog::level::level_enum level, const std::string& traceparent,
                  std::int64_t sequence_number) {
  std::ostringstream log;
  // Before the server has threads, and back when it has none any more.
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
  {
    const TestServer server;
    spdlog::set_level(level);
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse uploaded;
    EXPECT_TRUE(UploadMap(*server.maps, HeaderOf(bytes), bytes, &uploaded).ok());
    Call call;
    call.AddMetadata("traceparent", traceparent);
    const auto stream = server.localization->Localize(&call);
    v1::LocalizeRequest request;
    *request.mutable_open() = OpenMessage();
    stream->Write(request);
    *request.mutable_scan() = ScanMessage(sequence_number);
    stream->Write(request);
    stream->WritesDone();
    v1::LocalizeResponse response;
    while (stream->Read(&response)) {
    }
    EXPECT_TRUE(stream->Finish().ok());
  }
  spdlog::set_default_logger(before);
  spdlog::set_level(spdlog::level::warn);
  return log.str();
}

TEST(StageLogTest, EachScanLogsItsStagesWithSessionAndTraceAtDebugOnly) {
  const std::string trace = "4bf92f3577b34da6a3ce929d0e0e4736";
  const std::string traceparent = "00-" + trace + "-00f067aa0ba902b7-01";
  const std::string debug = LogOf(spdlog::level::debug, traceparent, 77);
  EXPECT_THAT(debug, HasSubstr("trace=" + trace + " sequence_number=77"));
  EXPECT_THAT(debug, HasSubstr("registration_us="));
  const std::string info = LogOf(spdlog::level::info, traceparent, 77);
  EXPECT_THAT(info, HasSubstr("trace=" + trace)) << "the session's opening";
  EXPECT_THAT(info, Not(HasSubstr("sequence_number=77"))) << "never per scan";
}

TEST_F(MetricsTest, RefusedOpeningsAreCountedByCode) {
  const auto open_and_end = [&](const v1::OpenSession& open) {
    TestSession session(*server_.localization);
    session.Open(open);
    session.CloseSending();
    EXPECT_FALSE(session.Finish().ok());
  };
  v1::OpenSession open = OpenMessage();
  open.set_map_name("nowhere");
  open_and_end(open);
  open.set_resume_token("unknown");
  open_and_end(open);
  open_and_end({});
  EXPECT_EQ(Value("dcloc_session_opens_total{code=\"not_found\",resumed=\"false\"}"), 1.0);
  EXPECT_EQ(Value("dcloc_session_opens_total{code=\"not_found\",resumed=\"true\"}"), 1.0);
  EXPECT_EQ(Value("dcloc_session_opens_total{code=\"invalid_argument\",resumed=\"false\"}"), 1.0);
}

TEST_F(MetricsTest, ADrainShows) {
  EXPECT_EQ(Value("dcloc_draining"), 0.0);
  EXPECT_EQ(Value("dcloc_self_probe_ok"), 1.0);
  EXPECT_EQ(Value("dcloc_replicas"), 1.0);
  EXPECT_EQ(Value("dcloc_connections_refused_total"), 0.0);
  EXPECT_THAT(Get(server_.server->metrics_address(), "/ready"), HasSubstr(" 200 "));
  Call call;
  v1::DrainResponse response;
  ASSERT_TRUE(server_.admin->Drain(&call, {}, &response).ok());
  EXPECT_EQ(Value("dcloc_draining"), 1.0);
  const std::string ready = Get(server_.server->metrics_address(), "/ready");
  EXPECT_THAT(ready, HasSubstr(" 503 "));
  EXPECT_THAT(ready, HasSubstr("draining"));
}

TEST_F(MetricsTest, OnlyMetricsAreServed) {
  const std::string address = server_.server->metrics_address();
  EXPECT_THAT(Get(address, "/etc/passwd"), HasSubstr(" 404 "));
  EXPECT_THAT(Get(address, "/metricsx"), HasSubstr(" 404 "));
  EXPECT_THAT(Get(address, "/metrics?x=1"), HasSubstr(" 200 "));
  EXPECT_THAT(Ask(address, "POST /metrics HTTP/1.1\r\n\r\n"), HasSubstr(" 405 "));
  EXPECT_THAT(Ask(address, "\r\n\r\n"), HasSubstr(" 405 "));
  EXPECT_THAT(Ask(address, std::string(8192, 'x')), HasSubstr(" 400 "));
}

TEST_F(MetricsTest, AClientThatSaysNothingHoldsUpNobodyForLong) {
  EXPECT_THAT(Ask(server_.server->metrics_address(), ""), HasSubstr(" 400 "));
  EXPECT_THAT(Scrape(), HasSubstr(" 200 "));
}

TEST_F(MetricsTest, AnAddressThatIsTakenIsAnError) {
  ServerConfig config = Config();
  TemporaryFolder folder;
  config.data = folder.path() / "store";
  config.listen = "127.0.0.1:0";
  config.metrics_listen = server_.server->metrics_address();
  const absl::Status status = Server::Start(config).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("metrics_listen"));
}

TEST(MetricsAddressTest, IsLoopbackWithoutAHost) {
  EXPECT_EQ(ParseMetricsAddress("9464")->ToString(), "127.0.0.1:9464");
  EXPECT_EQ(ParseMetricsAddress("0.0.0.0:9464")->ToString(), "0.0.0.0:9464");
  for (const char* text : {"", "x", "70000", "-1", "host", ":9464", "::1:9464"}) {
    const absl::Status status = ParseMetricsAddress(text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("metrics_listen")) << text;
  }
  ServerConfig config;
  config.data = "store";
  EXPECT_TRUE(Validate(config).ok());
  config.metrics_listen = "host";
  EXPECT_EQ(Validate(config).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc::server
