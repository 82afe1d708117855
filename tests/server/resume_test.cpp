#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/test_maps.h"
#include "tests/server/test_server.h"

// Sequence numbers, resuming, dropping, draining and ending, as the contract's comments have them.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

v1::OpenSession ResumableOpen() {
  v1::OpenSession open = OpenMessage();
  open.set_resumable(true);
  return open;
}

v1::OpenSession ResumeOpen(const std::string& token, const std::string& vehicle_id = "car-1") {
  v1::OpenSession open;
  open.set_vehicle_id(vehicle_id);
  open.set_resume_token(token);
  return open;
}

class ResumeTest : public ::testing::Test {
 protected:
  explicit ResumeTest(const ServerConfig& config = TestServer::StubConfig()) : server_(config) {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  }

  std::unique_ptr<TestSession> Connect() {
    return std::make_unique<TestSession>(*server_.localization);
  }

  v1::SessionOpened Open(TestSession& session, const v1::OpenSession& open) {
    EXPECT_TRUE(session.Open(open));
    const auto opened = session.Read();
    EXPECT_TRUE(opened.has_value()) << session.Finish().error_message();
    return opened ? opened->opened() : v1::SessionOpened();
  }

  grpc::Status StatusOf(const v1::OpenSession& open) {
    TestSession session(*server_.localization);
    session.Open(open);
    return session.Finish();
  }

  v1::GetServerStateResponse State() {
    Call call;
    v1::GetServerStateResponse response;
    EXPECT_TRUE(server_.admin->GetServerState(&call, {}, &response).ok());
    return response;
  }

  v1::Session Get(const std::string& session_id) {
    Call call;
    v1::GetSessionRequest request;
    request.set_session_id(session_id);
    v1::GetSessionResponse response;
    EXPECT_TRUE(server_.admin->GetSession(&call, request, &response).ok());
    return response.session();
  }

  grpc::Status End(const std::string& session_id, const std::string& reason) {
    Call call;
    v1::EndSessionRequest request;
    request.set_session_id(session_id);
    request.set_reason(reason);
    v1::EndSessionResponse response;
    return server_.admin->EndSession(&call, request, &response);
  }

  void WaitUntilDetached(int count = 1) {
    ASSERT_TRUE(Eventually([&] { return State().detached_session_count() == count; }));
  }

  TestServer server_;
};

// ---- Sequence numbers

TEST_F(ResumeTest, ADuplicateIsAnsweredFromMemoryByItsNumberAlone) {
  TestSession session(*server_.localization);
  const v1::SessionOpened opened = Open(session, OpenMessage());
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(session.Localize(ScanMessage(i))->has_result());
  const auto first = session.Localize(ScanMessage(5));
  v1::Scan number_alone;
  number_alone.set_sequence_number(5);
  auto again = session.Localize(number_alone);
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(again->from_memory());
  again->set_from_memory(false);
  EXPECT_EQ(again->SerializeAsString(), first->SerializeAsString());
  EXPECT_NEAR(session.Localize(ScanMessage(6))->result().pose().pose().translation_m().x(),
              6 * 0.77, 1e-9)
      << "it was not localized twice";
  EXPECT_EQ(Get(opened.session_id()).repeated_scan_count(), 1);
  EXPECT_EQ(Get(opened.session_id()).scan_count(), 7);
}

TEST_F(ResumeTest, AGapIsLocalizedAndWhatWasSkippedIsLate) {
  TestSession session(*server_.localization);
  const v1::SessionOpened opened = Open(session, OpenMessage());
  ASSERT_TRUE(session.Localize(ScanMessage(100))->has_result());
  ASSERT_TRUE(session.Localize(ScanMessage(104))->has_result());
  const auto late = session.Localize(ScanMessage(102));
  ASSERT_TRUE(late->has_rejected());
  EXPECT_EQ(late->rejected().code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_THAT(late->rejected().message(), HasSubstr("scan.sequence_number is 102"));
  EXPECT_EQ(Get(opened.session_id()).missing_scan_count(), 3);
  EXPECT_EQ(Get(opened.session_id()).last_sequence_number(), 104);
}

TEST_F(ResumeTest, ARejectionIsRememberedToo) {
  TestSession session(*server_.localization);
  Open(session, OpenMessage());
  v1::Scan broken = ScanMessage(1);
  broken.set_radar_id("nobody");
  const auto rejected = session.Localize(broken);
  ASSERT_TRUE(session.Localize(ScanMessage(2))->has_result());
  const auto again = session.Localize(broken);
  ASSERT_TRUE(again->has_rejected());
  EXPECT_TRUE(again->from_memory());
  EXPECT_EQ(again->rejected().message(), rejected->rejected().message());
}

class ForgetfulTest : public ResumeTest {
 protected:
  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.answer_history_count = 3;
    return config;
  }
  ForgetfulTest() : ResumeTest(Config()) {}
};

TEST_F(ForgetfulTest, TheMemoryIsAsLongAsItSays) {
  TestSession session(*server_.localization);
  EXPECT_EQ(Open(session, OpenMessage()).answer_history_count(), 3);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(session.Localize(ScanMessage(i))->has_result());
  EXPECT_TRUE(session.Localize(ScanMessage(7))->from_memory());
  EXPECT_EQ(session.Localize(ScanMessage(6))->rejected().code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_TRUE(session.Localize(ScanMessage(7))->from_memory()) << "late ones push nothing out";
}

TEST_F(ResumeTest, AStampFarFromTheServersClockIsAcceptedAndReported) {
  TestSession session(*server_.localization);
  const v1::SessionOpened opened = Open(session, OpenMessage());
  v1::Scan scan = ScanMessage(1);
  scan.set_stamp_ns(1'000'000'000);  // 1970
  const auto answer = session.Localize(scan);
  ASSERT_TRUE(answer->has_result());
  constexpr std::int64_t kDecade_ns = 315'360'000'000'000'000;
  EXPECT_GT(answer->result().timings().stamp_age_ns(), 5 * kDecade_ns);
  EXPECT_EQ(Get(opened.session_id()).last_stamp_age_ns(),
            answer->result().timings().stamp_age_ns());
}

// ---- Resuming

TEST_F(ResumeTest, ASessionGoesOnOnAnotherStream) {
  auto session = Connect();
  const v1::SessionOpened opened = Open(*session, ResumableOpen());
  EXPECT_EQ(opened.resume_token().size(), 32U);
  EXPECT_FALSE(opened.resumed());
  EXPECT_FALSE(opened.has_last_sequence_number());
  EXPECT_EQ(opened.detached_timeout_ns(), 60'000'000'000);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(session->Localize(ScanMessage(i))->has_result());
  session->Cancel();
  session.reset();
  WaitUntilDetached();
  EXPECT_TRUE(Get(opened.session_id()).detached());

  TestSession next(*server_.localization);
  const v1::SessionOpened resumed = Open(next, ResumeOpen(opened.resume_token()));
  EXPECT_TRUE(resumed.resumed());
  EXPECT_EQ(resumed.session_id(), opened.session_id());
  EXPECT_EQ(resumed.last_sequence_number(), 2);
  EXPECT_EQ(State().detached_session_count(), 0);
  EXPECT_TRUE(next.Localize(ScanMessage(2))->from_memory());
  EXPECT_NEAR(next.Localize(ScanMessage(3))->result().pose().pose().translation_m().x(), 3 * 0.77,
              1e-9);
  EXPECT_EQ(Get(opened.session_id()).resume_count(), 1);
  EXPECT_EQ(State().resume_count(), 1);
}

TEST_F(ResumeTest, AHalfClosedSessionWaitsAndAClosedOneDoesNot) {
  TestSession half_closed(*server_.localization);
  const v1::SessionOpened opened = Open(half_closed, ResumableOpen());
  half_closed.CloseSending();
  EXPECT_TRUE(half_closed.Finish().ok());
  WaitUntilDetached();

  TestSession closed(*server_.localization);
  Open(closed, ResumeOpen(opened.resume_token()));
  ASSERT_TRUE(closed.Send(ScanMessage(1)));
  v1::LocalizeRequest close;
  close.mutable_close();
  ASSERT_TRUE(closed.Send(close));
  EXPECT_TRUE(closed.Read()->has_result()) << "what was sent before is answered";
  EXPECT_TRUE(closed.Finish().ok());
  EXPECT_EQ(State().session_count(), 0);
  const grpc::Status gone = StatusOf(ResumeOpen(opened.resume_token()));
  EXPECT_EQ(gone.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(gone.error_message(), HasSubstr("its client closed it"));
}

TEST_F(ResumeTest, ASecondStreamTakesTheSessionOver) {
  TestSession first(*server_.localization);
  const v1::SessionOpened opened = Open(first, ResumableOpen());
  ASSERT_TRUE(first.Localize(ScanMessage(0))->has_result());
  TestSession second(*server_.localization);
  EXPECT_TRUE(Open(second, ResumeOpen(opened.resume_token())).resumed());
  EXPECT_EQ(first.Finish().error_code(), grpc::StatusCode::ABORTED);
  EXPECT_TRUE(second.Localize(ScanMessage(1))->has_result());
  EXPECT_EQ(State().session_count(), 1);
}

TEST_F(ResumeTest, TokensThatDoNotFitAreRefused) {
  const grpc::Status unknown = StatusOf(ResumeOpen(std::string(32, 'a')));
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(unknown.error_message(), HasSubstr("may have been restarted"));
  TestSession session(*server_.localization);
  const v1::SessionOpened opened = Open(session, ResumableOpen());
  const grpc::Status other = StatusOf(ResumeOpen(opened.resume_token(), "car-2"));
  EXPECT_EQ(other.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(other.error_message(), HasSubstr("car-1's"));
  EXPECT_TRUE(session.Localize(ScanMessage(0))->has_result()) << "and it is not disturbed";
}

class ShortLivedTest : public ResumeTest {
 protected:
  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.session_detached_timeout_ms = 100;
    config.session_idle_timeout_ms = 400;
    config.max_session_count = 2;
    return config;
  }
  ShortLivedTest() : ResumeTest(Config()) {}
};

TEST_F(ShortLivedTest, ADetachedSessionIsReapedWithItsMap) {
  auto session = Connect();
  const v1::SessionOpened opened = Open(*session, ResumableOpen());
  session->Cancel();
  session.reset();
  EXPECT_TRUE(Eventually([&] {
    const v1::GetServerStateResponse state = State();
    return state.session_count() == 0 && state.loaded_map_count() == 0;
  }));
  const grpc::Status gone = StatusOf(ResumeOpen(opened.resume_token()));
  EXPECT_EQ(gone.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(gone.error_message(), HasSubstr("without a stream for more than 100ms"));
}

TEST_F(ShortLivedTest, AnIdleSessionIsEndedAndTold) {
  TestSession session(*server_.localization);
  Open(session, ResumableOpen());
  const auto ending = session.Read();
  ASSERT_TRUE(ending.has_value() && ending->has_ending());
  EXPECT_EQ(ending->ending().reason(), v1::SESSION_END_REASON_IDLE);
  const grpc::Status status = session.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_THAT(status.error_message(), HasSubstr("no scan came for 400ms"));
}

TEST_F(ShortLivedTest, AReaderThatIsStuckIsIdleInTheEndAndCutOff) {
  TestSession stuck(*server_.localization);
  Open(stuck, OpenMessage());
  std::thread writer([&] {
    for (int i = 0; stuck.Send(ScanMessage(i, 2000)); ++i) {
    }
  });
  EXPECT_TRUE(Eventually([&] { return State().session_count() == 0; }));
  writer.join();
  EXPECT_FALSE(stuck.Finish().ok());
}

class NeverReapedTest : public ResumeTest {
 protected:
  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.max_session_count = 2;
    return config;
  }
  NeverReapedTest() : ResumeTest(Config()) {}
};

TEST_F(NeverReapedTest, ADetachedSessionMakesRoomForANewOne) {
  auto first = Connect();
  const v1::SessionOpened opened = Open(*first, ResumableOpen());
  first->Cancel();
  first.reset();
  WaitUntilDetached();
  TestSession second(*server_.localization);
  Open(second, OpenMessage());
  // A stream counts until the transport is done with it, also the first one.
  std::unique_ptr<TestSession> third;
  ASSERT_TRUE(Eventually([&] {
    third = Connect();
    return third->Open(OpenMessage()) && third->Read().has_value();
  }));
  EXPECT_EQ(State().session_count(), 2);
  third->CloseSending();
  EXPECT_TRUE(third->Finish().ok());
  grpc::Status status = StatusOf(ResumeOpen(opened.resume_token()));
  for (int i = 0; i < 500 && status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    status = StatusOf(ResumeOpen(opened.resume_token()));
  }
  EXPECT_THAT(status.error_message(), HasSubstr("others needed the place"));
}

// ---- Dropping

TEST_F(ResumeTest, TheOldestAreDroppedOnRequestAndEachHasItsAnswer) {
  TestSession session(*server_.localization);
  v1::OpenSession open = OpenMessage();
  open.set_queue_policy(v1::QUEUE_POLICY_DROP_OLDEST);
  Open(session, open);
  constexpr int kScans = 3000;
  std::thread writer([&] {
    for (int i = 0; i < kScans; ++i) ASSERT_TRUE(session.Send(ScanMessage(i, 1000)));
    session.CloseSending();
  });
  int dropped = 0;
  std::int64_t said = 0;
  for (int i = 0; i < kScans; ++i) {
    const auto answer = session.Read();
    ASSERT_TRUE(answer.has_value());
    said = answer->dropped_scan_count();
    if (answer->has_result()) {
      ASSERT_EQ(answer->result().sequence_number(), i);
    } else {
      ASSERT_EQ(answer->rejected().sequence_number(), i);
      ASSERT_EQ(answer->rejected().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
      ++dropped;
    }
  }
  writer.join();
  EXPECT_TRUE(session.Finish().ok());
  EXPECT_GT(dropped, 0);
  EXPECT_EQ(said, dropped);
  EXPECT_EQ(State().dropped_scan_count(), dropped);
}

// ---- Operators

TEST_F(ResumeTest, AnOperatorEndsASession) {
  TestSession session(*server_.localization);
  const v1::SessionOpened opened = Open(session, ResumableOpen());
  EXPECT_TRUE(End(opened.session_id(), "wrong map").ok());
  EXPECT_TRUE(session.Read()->has_ending());
  const grpc::Status status = session.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(status.error_message(), "an operator ended it: wrong map");
  EXPECT_EQ(StatusOf(ResumeOpen(opened.resume_token())).error_code(), grpc::StatusCode::NOT_FOUND);
  const grpc::Status again = End(opened.session_id(), "");
  EXPECT_EQ(again.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(again.error_message(), HasSubstr("wrong map"));
  EXPECT_EQ(End(opened.session_id(), std::string(300, 'x')).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(ResumeTest, AWatcherSeesTheAnswersUntilTheEnd) {
  TestSession session(*server_.localization);
  const v1::SessionOpened opened = Open(session, OpenMessage());
  Call call;
  v1::WatchSessionRequest request;
  request.set_session_id(opened.session_id());
  const auto watcher = server_.admin->WatchSession(&call, request);
  watcher->WaitForInitialMetadata();
  std::vector<std::string> answers;
  answers.reserve(20);
  for (int i = 0; i < 20; ++i) {
    answers.push_back(session.Localize(ScanMessage(i))->SerializeAsString());
  }
  session.CloseSending();
  EXPECT_TRUE(session.Finish().ok());
  v1::WatchSessionResponse response;
  for (const std::string& answer : answers) {
    ASSERT_TRUE(watcher->Read(&response));
    EXPECT_EQ(response.answer().SerializeAsString(), answer);
    EXPECT_EQ(response.missed_answer_count(), 0);
  }
  EXPECT_FALSE(watcher->Read(&response));
  EXPECT_TRUE(watcher->Finish().ok());

  Call late;
  const auto nobody = server_.admin->WatchSession(&late, request);
  EXPECT_FALSE(nobody->Read(&response));
  EXPECT_EQ(nobody->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(ResumeTest, ADrainingServerTellsWhoCanMoveAndEndsTheRest) {
  TestSession movable(*server_.localization);
  Open(movable, ResumableOpen());
  TestSession plain(*server_.localization);
  Open(plain, OpenMessage());
  Call call;
  v1::DrainResponse response;
  ASSERT_TRUE(server_.admin->Drain(&call, {}, &response).ok());
  EXPECT_EQ(response.session_count(), 1);
  EXPECT_TRUE(State().draining());
  const auto ending = movable.Read();
  ASSERT_TRUE(ending.has_value() && ending->has_ending());
  EXPECT_EQ(ending->ending().reason(), v1::SESSION_END_REASON_DRAINING);
  EXPECT_EQ(ending->ending().grace_duration_ns(), 1'000'000'000);
  EXPECT_TRUE(plain.Localize(ScanMessage(0))->has_result()) << "there is a grace";
  EXPECT_EQ(StatusOf(OpenMessage()).error_code(), grpc::StatusCode::UNAVAILABLE);
  movable.CloseSending();
  EXPECT_TRUE(movable.Finish().ok());
  EXPECT_EQ(plain.Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace dcloc::server
