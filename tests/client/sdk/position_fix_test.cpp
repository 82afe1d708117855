#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <future>
#include <string>

#include "client/sdk/recording.h"
#include "client/sdk/session.h"
#include "tests/client/sdk/fake_server.h"
#include "tests/core/map/temporary_folder.h"

// Position fixes through a session.
namespace dcloc::client {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

v1::Scan FixlessScan(std::int64_t number) {
  v1::Scan scan;
  scan.set_sequence_number(number);
  return scan;
}

v1::PositionFix FixOf(std::int64_t stamp_ns) {
  v1::PositionFix fix;
  fix.set_stamp_ns(stamp_ns);
  return fix;
}

/// Reads the `open` and opens a session that can be resumed, and takes fixes.
void AcceptWithFixes(LocalizeServerStream& stream) {
  v1::LocalizeRequest request;
  stream.Read(&request);
  v1::LocalizeResponse opened;
  opened.mutable_opened()->set_resume_token("token");
  opened.mutable_opened()->set_takes_position_fixes(true);
  stream.Write(opened);
}

void Answer(const v1::LocalizeRequest& request, LocalizeServerStream& stream) {
  v1::LocalizeResponse response;
  if (request.has_position_fix()) {
    response.mutable_position_fix_answer()->set_stamp_ns(request.position_fix().stamp_ns());
    response.mutable_position_fix_answer()->set_use(v1::FIX_USE_FUSED);
  } else {
    response.mutable_result()->set_sequence_number(request.scan().sequence_number());
  }
  stream.Write(response);
}

grpc::Status AnswerScansAndFixes(grpc::ServerContext& /*context*/, LocalizeServerStream& stream) {
  AcceptWithFixes(stream);
  v1::LocalizeRequest request;
  while (stream.Read(&request) && !request.has_close()) Answer(request, stream);
  return grpc::Status::OK;
}

std::unique_ptr<Session> OpenSession(const FakeServer& server, const SessionOptions& options = {}) {
  v1::OpenSession open;
  open.set_vehicle_id("car");
  auto session = Session::Open(server.Channel(), open, options);
  EXPECT_TRUE(session.ok()) << session.status();
  return *std::move(session);
}

TEST(SessionFixTest, FixesAreAnsweredInTheirPlaceAmongTheScans) {
  const FakeServer server(AnswerScansAndFixes);
  const auto session = OpenSession(server);
  ASSERT_TRUE(session->SendFix(FixOf(10)).ok());
  ASSERT_TRUE(session->Send(FixlessScan(1)).ok());
  ASSERT_TRUE(session->SendFix(FixOf(20)).ok());
  ASSERT_TRUE(session->Send(FixlessScan(2)).ok());
  session->CloseSending();
  EXPECT_EQ(session->Next()->position_fix_answer().stamp_ns(), 10);
  EXPECT_EQ(session->Next()->result().sequence_number(), 1);
  EXPECT_EQ(session->Next()->position_fix_answer().stamp_ns(), 20);
  EXPECT_EQ(session->Next()->result().sequence_number(), 2);
  EXPECT_FALSE(session->Next().has_value());
  EXPECT_TRUE(session->EndStatus().ok()) << session->EndStatus();
  EXPECT_EQ(session->SendFix(FixOf(30)).code(), absl::StatusCode::kFailedPrecondition);
}

TEST(SessionFixTest, AnOlderServerIsNeverSentOne) {
  const FakeServer server(AnswerAll);
  const auto session = OpenSession(server, {.when_full = FullQueue::kBlock});
  const absl::Status status = session->SendFix(FixOf(10));
  EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
  ASSERT_TRUE(session->Send(FixlessScan(1)).ok());
  EXPECT_EQ(session->Next()->result().sequence_number(), 1);
}

TEST(SessionFixTest, UnansweredFixesAreBoundedAndHoldNoScanBack) {
  std::promise<void> go_on;
  std::shared_future<void> may_go_on = go_on.get_future().share();
  const FakeServer server([may_go_on](grpc::ServerContext& context, LocalizeServerStream& stream) {
    AcceptWithFixes(stream);
    may_go_on.wait();
    v1::LocalizeRequest request;
    while (!context.IsCancelled() && stream.Read(&request)) Answer(request, stream);
    return grpc::Status::OK;
  });
  const auto session = OpenSession(server, {.max_unanswered_fix_count = 3});
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(session->SendFix(FixOf(i)).ok());
  const absl::Status status = session->SendFix(FixOf(3));
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("max_unanswered_fix_count is 3"));
  ASSERT_TRUE(session->Send(FixlessScan(1)).ok());
  go_on.set_value();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(session->Next()->has_position_fix_answer());
  EXPECT_TRUE(session->SendFix(FixOf(4)).ok());
  EXPECT_EQ(session->Next()->result().sequence_number(), 1);
  EXPECT_EQ(session->Next()->position_fix_answer().stamp_ns(), 4);
}

/// The first stream breaks once it has read a scan, a fix and a scan; the second one answers all.
class BreakingServer {
 public:
  grpc::Status operator()(grpc::ServerContext& context, LocalizeServerStream& stream) {
    if (stream_count_++ > 0) return AnswerScansAndFixes(context, stream);
    AcceptWithFixes(stream);
    v1::LocalizeRequest request;
    for (int i = 0; i < 3; ++i) stream.Read(&request);
    return {grpc::StatusCode::UNAVAILABLE, "broken"};
  }

 private:
  std::atomic<int> stream_count_ = 0;
};

SessionOptions Reconnecting() {
  return {.reconnect = ReconnectOptions{.initial_backoff = 10ms, .max_backoff = 50ms}};
}

TEST(SessionFixTest, AFixIsNotSentAgainWhenTheConnectionBreaks) {
  BreakingServer behaviour;
  const FakeServer server(std::ref(behaviour));
  const auto session = OpenSession(server, Reconnecting());
  ASSERT_TRUE(session->Send(FixlessScan(1)).ok());
  ASSERT_TRUE(session->SendFix(FixOf(10)).ok());
  ASSERT_TRUE(session->Send(FixlessScan(2)).ok());
  EXPECT_EQ(session->Next()->result().sequence_number(), 1);
  EXPECT_EQ(session->Next()->result().sequence_number(), 2);
  EXPECT_EQ(session->stats().lost_fix_count, 1);
  ASSERT_TRUE(session->SendFix(FixOf(20)).ok());
  EXPECT_EQ(session->Next()->position_fix_answer().stamp_ns(), 20);
}

/// The entries of a recording, "scan" and "fix", and whether it is whole.
std::string EntriesOf(const std::filesystem::path& file) {
  auto reader = RecordingReader::Open(file);
  if (!reader.ok()) return std::string(reader.status().message());
  std::string entries;
  while (true) {
    const auto next = reader->Next();
    if (!next.ok()) return std::string(next.status().message());
    if (!next->has_value()) return entries + reader->end_reason();
    entries += (*next)->has_fix() ? "fix " : "scan ";
  }
}

TEST(SessionFixTest, ARecordingHasTheFixesInTheirPlace) {
  const TemporaryFolder folder;
  const FakeServer server(AnswerScansAndFixes);
  const std::string file = (folder.path() / "session.rec").string();
  const auto session = OpenSession(server, {.record_file = file});
  ASSERT_TRUE(session->Send(FixlessScan(1)).ok());
  ASSERT_TRUE(session->SendFix(FixOf(10)).ok());
  ASSERT_TRUE(session->Send(FixlessScan(2)).ok());
  session->CloseSending();
  while (session->Next()) {
  }
  EXPECT_TRUE(session->record_status().ok()) << session->record_status();
  EXPECT_EQ(EntriesOf(file), "scan fix scan the session has ended");
}

TEST(SessionFixTest, ARecordingEndsWhereAFixWasLost) {
  const TemporaryFolder folder;
  BreakingServer behaviour;
  const FakeServer server(std::ref(behaviour));
  SessionOptions options = Reconnecting();
  options.record_file = (folder.path() / "session.rec").string();
  const auto session = OpenSession(server, options);
  ASSERT_TRUE(session->Send(FixlessScan(1)).ok());
  ASSERT_TRUE(session->SendFix(FixOf(10)).ok());
  ASSERT_TRUE(session->Send(FixlessScan(2)).ok());
  ASSERT_TRUE(session->Next()->has_result());
  ASSERT_TRUE(session->Next()->has_result());
  session->CloseSending();
  EXPECT_FALSE(session->Next().has_value());
  EXPECT_EQ(EntriesOf(options.record_file), "a position fix was lost with the connection");
}

}  // namespace
}  // namespace dcloc::client
