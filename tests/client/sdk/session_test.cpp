#include "client/sdk/session.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <future>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "client/sdk/channel.h"
#include "tests/client/sdk/fake_server.h"

namespace dcloc::client {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

v1::OpenSession Vehicle(const std::string& id) {
  v1::OpenSession open;
  open.set_vehicle_id(id);
  return open;
}

v1::Scan ScanNumber(std::int64_t number, const std::string& radar_id = "front") {
  v1::Scan scan;
  scan.set_sequence_number(number);
  scan.set_radar_id(radar_id);
  return scan;
}

std::unique_ptr<Session> Open(const FakeServer& server, const SessionOptions& options = {}) {
  auto session = Session::Open(server.Channel(), Vehicle("car"), options);
  EXPECT_TRUE(session.ok()) << session.status();
  return *std::move(session);
}

TEST(SessionTest, EachScanIsAnsweredInOrder) {
  const FakeServer server(AnswerAll);
  const auto session = Open(server, {.max_queued_scan_count = 3, .when_full = FullQueue::kBlock});
  EXPECT_EQ(session->opened().session_id(), "session of car");
  EXPECT_EQ(session->EndStatus().code(), absl::StatusCode::kFailedPrecondition);
  constexpr int kScans = 2000;
  std::thread sender([&] {
    for (int i = 0; i < kScans; ++i) {
      EXPECT_TRUE(session->Send(ScanNumber(i, i % 7 == 0 ? "broken" : "front")).ok());
    }
    session->CloseSending();
  });
  for (int i = 0; i < kScans; ++i) {
    const auto answer = session->Next();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->has_rejected(), i % 7 == 0);
    EXPECT_EQ(
        i % 7 == 0 ? answer->rejected().sequence_number() : answer->result().sequence_number(), i);
  }
  EXPECT_FALSE(session->Next().has_value());
  EXPECT_TRUE(session->EndStatus().ok()) << session->EndStatus();
  sender.join();
  EXPECT_EQ(session->Send(ScanNumber(0)).code(), absl::StatusCode::kFailedPrecondition);
}

/// A server of a fleet that goes on from scan `last`, or from none where it is negative.
void GoOn(LocalizeServerStream& stream, int epoch, int last, bool resumed) {
  v1::LocalizeRequest request;
  stream.Read(&request);
  v1::LocalizeResponse response;
  v1::SessionOpened& opened = *response.mutable_opened();
  opened.set_resume_token("token");
  opened.set_resumed(resumed);
  opened.set_epoch(epoch);
  opened.set_ticket_interval_ns(1'000'000'000);
  if (last >= 0) opened.set_last_sequence_number(last);
  if (request.open().has_answered_sequence_number() && !resumed) {
    opened.set_ticket_use(v1::TICKET_USE_ACCEPTED);
  }
  stream.Write(response);
}

TEST(SessionTest, ASessionThatIsResumedWhileItCatchesUpGetsTheRest) {
  const grpc::Status gone(grpc::StatusCode::UNAVAILABLE, "gone");
  int attempt = 0;
  std::vector<std::int64_t> sent;
  const FakeServer server([&](grpc::ServerContext&, LocalizeServerStream& stream) {
    v1::LocalizeRequest request;
    if (++attempt == 2) {
      GoOn(stream, 2, 4, /*resumed=*/false);
      stream.Read(&request);
      sent.push_back(request.scan().sequence_number());
      return gone;
    }
    attempt == 1 ? GoOn(stream, 1, -1, false) : GoOn(stream, 2, 5, /*resumed=*/true);
    while (stream.Read(&request) && request.has_scan()) {
      const std::int64_t number = request.scan().sequence_number();
      if (attempt > 1) sent.push_back(number);
      if (attempt > 1 && number < 10) continue;  // its answer is there
      v1::LocalizeResponse response;
      response.mutable_result()->set_sequence_number(number);
      if (number == 9) {
        response.mutable_ticket()->set_sealed("ticket");
        response.mutable_ticket()->set_last_sequence_number(4);
      }
      stream.Write(response);
      if (number == 9) return gone;
    }
    return grpc::Status::OK;
  });
  const auto session = Open(server, {.reconnect = ReconnectOptions{.initial_backoff = 1ms}});
  for (int i = 0; i <= 10; ++i) {
    ASSERT_TRUE(session->Send(ScanNumber(i)).ok());
    const auto answer = session->Next();
    ASSERT_TRUE(answer.has_value()) << session->EndStatus();
    EXPECT_EQ(answer->result().sequence_number(), i);
  }
  EXPECT_EQ(sent, (std::vector<std::int64_t>{5, 6, 7, 8, 9, 10}));
}

TEST(SessionTest, AProxyIsToldWhoseStreamItIs) {
  std::mutex mutex;
  std::vector<std::string> names;
  const FakeServer server([&](grpc::ServerContext& context, LocalizeServerStream& stream) {
    const auto& metadata = context.client_metadata();
    const auto name = metadata.find("x-session-id");
    {
      const std::lock_guard lock(mutex);
      names.push_back(
          name == metadata.end() ? "none" : std::string(name->second.data(), name->second.size()));
    }
    return AnswerAll(context, stream);
  });
  // What could not be a header is for the server to refuse, and must not end the process.
  for (const char* id : {"car-17", "two words", "\xc3\xa9", "line\nbreak", ""}) {
    const auto session = Session::Open(server.Channel(), Vehicle(id));
    EXPECT_TRUE(session.ok()) << session.status();
  }
  const std::lock_guard lock(mutex);
  EXPECT_THAT(names, ::testing::Contains("car-17"));
  EXPECT_THAT(names, ::testing::Each(::testing::AnyOf("car-17", "none")));
}

TEST(SessionTest, ThreadsMaySendAtTheSameTime) {
  const FakeServer server(AnswerAll);
  const auto session = Open(server, {.max_queued_scan_count = 2, .when_full = FullQueue::kBlock});
  std::vector<std::thread> senders;
  senders.reserve(4);
  for (int thread = 0; thread < 4; ++thread) {
    senders.emplace_back([&, thread] {
      for (int i = 0; i < 200; ++i) {
        EXPECT_TRUE(session->Send(ScanNumber(1000 * thread + i)).ok());
      }
    });
  }
  std::array<std::int64_t, 4> last{-1, -1, -1, -1};
  for (int i = 0; i < 800; ++i) {
    const std::int64_t number = session->Next()->result().sequence_number();
    // Of one thread's scans the order stays.
    EXPECT_GT(number % 1000, last[static_cast<std::size_t>(number / 1000)]);
    last[static_cast<std::size_t>(number / 1000)] = number % 1000;
  }
  for (std::thread& sender : senders) sender.join();
}

TEST(SessionTest, TheServersRefusalIsHandedOn) {
  const FakeServer server([](grpc::ServerContext&, LocalizeServerStream&) {
    return grpc::Status(grpc::StatusCode::NOT_FOUND,
                        "map_name is \"nowhere\"; there is no such map");
  });
  const auto session = Session::Open(server.Channel(), Vehicle("car"));
  EXPECT_EQ(session.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(session.status().message()), HasSubstr("nowhere"));
}

TEST(SessionTest, AServerThatAnswersBeforeItOpensIsNotBelieved) {
  const FakeServer server([](grpc::ServerContext& context, LocalizeServerStream& stream) {
    v1::LocalizeResponse answer;
    answer.mutable_result()->set_sequence_number(1);
    stream.Write(answer);
    while (!context.IsCancelled()) std::this_thread::sleep_for(1ms);
    return grpc::Status::OK;
  });
  EXPECT_FALSE(Session::Open(server.Channel(), Vehicle("car")).ok());
}

// Opens, then neither reads nor writes.
grpc::Status Sleep(grpc::ServerContext& context, LocalizeServerStream& stream) {
  AcceptOpen(stream);
  while (!context.IsCancelled()) std::this_thread::sleep_for(1ms);
  return grpc::Status::OK;
}

// Large enough that the transport's windows hold only a few.
v1::Scan LargeScan() {
  v1::Scan scan = ScanNumber(1);
  scan.mutable_range_m()->Resize(20'000, 1.0F);
  return scan;
}

TEST(SessionTest, AFullQueueRejects) {
  const FakeServer server(Sleep);
  const auto session = Open(server, {.max_queued_scan_count = 4, .when_full = FullQueue::kReject});
  absl::Status status;
  int accepted = 0;
  while (status.ok() && accepted < 1000) {
    status = session->Send(LargeScan());
    if (status.ok()) ++accepted;
  }
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("holds 4 scans"));
  EXPECT_GE(accepted, 4);
}

TEST(SessionTest, AnEndWakesABlockedSend) {
  FakeServer server(Sleep);
  const auto session = Open(server, {.max_queued_scan_count = 1, .when_full = FullQueue::kBlock});
  std::atomic<int> sent = 0;
  std::thread sender([&] {
    while (session->Send(LargeScan()).ok()) ++sent;
  });
  // Until nothing moves any more.
  for (int before = -1; before != sent || before < 1; std::this_thread::sleep_for(100ms)) {
    before = sent;
  }
  server.Die();
  sender.join();
  EXPECT_FALSE(session->Next().has_value());
  EXPECT_FALSE(session->EndStatus().ok());
}

TEST(SessionTest, AServerThatDiesMidStreamLeavesTheAnswersItGave) {
  FakeServer server(AnswerAll);
  const auto session = Open(server);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(session->Send(ScanNumber(i)).ok());
  EXPECT_EQ(session->Next()->result().sequence_number(), 0);
  std::this_thread::sleep_for(200ms);  // the other four have arrived
  server.Die();
  for (int i = 1; i < 5; ++i) EXPECT_EQ(session->Next()->result().sequence_number(), i);
  EXPECT_FALSE(session->Next().has_value());
  const absl::Status status = session->EndStatus();
  EXPECT_TRUE(absl::IsUnavailable(status) || absl::IsCancelled(status)) << status;
  EXPECT_EQ(session->Send(ScanNumber(6)).code(), absl::StatusCode::kUnavailable);
}

TEST(SessionTest, AnEndWithScansUnansweredIsNoGoodEnd) {
  const FakeServer server([](grpc::ServerContext&, LocalizeServerStream& stream) {
    AcceptOpen(stream);
    v1::LocalizeRequest request;
    stream.Read(&request);
    return grpc::Status::OK;
  });
  const auto session = Open(server);
  ASSERT_TRUE(session->Send(ScanNumber(1)).ok());
  EXPECT_FALSE(session->Next().has_value());
  EXPECT_EQ(session->EndStatus().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(session->EndStatus().message()), HasSubstr("1 scans unanswered"));
}

TEST(SessionTest, WhoDoesNotTakeTheAnswersHoldsTheServerBack) {
  std::atomic<int> written = 0;
  const FakeServer server([&](grpc::ServerContext&, LocalizeServerStream& stream) {
    AcceptOpen(stream);
    v1::LocalizeRequest request;
    v1::LocalizeResponse answer;
    answer.mutable_rejected()->set_message(std::string(100'000, 'x'));
    while (stream.Read(&request) && stream.Write(answer)) ++written;
    return grpc::Status::OK;
  });
  const auto session = Open(server, {.when_full = FullQueue::kBlock,
                                     .max_unread_answer_count = 5,
                                     .max_unanswered_scan_count = 10'000});
  std::thread sender([&] {
    while (session->Send(ScanNumber(0)).ok()) {
    }
  });
  for (int before = -1; before != written || before < 5; std::this_thread::sleep_for(100ms)) {
    before = written;
  }
  // The five, and what the transport's windows hold: far from a gigabyte.
  const int held = written;
  EXPECT_LT(held, 500);
  // Taking them lets it go on.
  for (int i = 0; i < held + 50; ++i) ASSERT_TRUE(session->Next().has_value());
  session->Cancel();
  sender.join();
}

TEST(SessionTest, CancelAndDestructionEndAtOnce) {
  const FakeServer server(Sleep);
  auto session = Open(server);
  auto next = std::async(std::launch::async, [&] { return session->Next(); });
  session->Cancel();
  EXPECT_FALSE(next.get().has_value());
  EXPECT_EQ(session->EndStatus().code(), absl::StatusCode::kCancelled);

  const auto begin = std::chrono::steady_clock::now();
  session = Open(server);
  ASSERT_TRUE(session->Send(LargeScan()).ok());
  session.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
}

TEST(SessionTest, DestructionWithUnreadAnswersEnds) {
  const FakeServer server(AnswerAll);
  auto session = Open(server, {.when_full = FullQueue::kBlock, .max_unread_answer_count = 1});
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(session->Send(ScanNumber(i)).ok());
  EXPECT_EQ(session->Next()->result().sequence_number(), 0);
  session.reset();
}

// Opening at `server` fails within the timeout and some slack.
absl::Status OpenStatus(const std::string& server, std::chrono::milliseconds timeout) {
  const auto channel = MakeChannel({.server = server});
  EXPECT_TRUE(channel.ok()) << channel.status();
  const auto begin = std::chrono::steady_clock::now();
  const auto session = Session::Open(*channel, Vehicle("car"), {.open_timeout = timeout});
  EXPECT_LT(std::chrono::steady_clock::now() - begin, timeout + 5s);
  return session.status();
}

TEST(SessionTest, NobodyListening) {
  std::string address;
  {
    const FakeServer gone(AnswerAll);
    address = gone.address();
  }
  const absl::Status status = OpenStatus(address, 20s);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(address));
}

TEST(SessionTest, AHostThatDoesNotExist) {
  const absl::Status status = OpenStatus("no-such-host.invalid:50051", 5s);
  EXPECT_TRUE(absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status)) << status;
}

TEST(SessionTest, AListenerThatSaysNothing) {
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(listener, 4), 0);
  ASSERT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const absl::Status status =
      OpenStatus("127.0.0.1:" + std::to_string(ntohs(address.sin_port)), 2s);
  EXPECT_EQ(status.code(), absl::StatusCode::kDeadlineExceeded) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("within 2000 ms"));
  close(listener);
}

TEST(SessionTest, OptionsErrorsNameTheField) {
  EXPECT_TRUE(Validate(SessionOptions()).ok());
  EXPECT_THAT(std::string(Validate({.max_queued_scan_count = 0}).message()),
              HasSubstr("max_queued_scan_count"));
  EXPECT_THAT(std::string(Validate({.max_unread_answer_count = 0}).message()),
              HasSubstr("max_unread_answer_count"));
  EXPECT_THAT(std::string(Validate({.open_timeout = -1ms}).message()), HasSubstr("-1 ms"));
  EXPECT_THAT(std::string(Validate({.max_unanswered_scan_count = 0}).message()),
              HasSubstr("max_unanswered_scan_count"));
  EXPECT_THAT(std::string(Validate({.max_unanswered_fix_count = 0}).message()),
              HasSubstr("max_unanswered_fix_count"));
  const ReconnectOptions shrinking{.initial_backoff = 2s, .max_backoff = 1s};
  EXPECT_THAT(std::string(Validate({.reconnect = shrinking}).message()),
              HasSubstr("reconnect.max_backoff is 1000 ms"));
}

}  // namespace
}  // namespace dcloc::client
