#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/localization/session_fixture.h"

// Sessions that outlive their streams, and those that nobody comes back to.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class ResumeTest : public SessionFixture {};

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

class ShortLivedTest : public SessionFixture {
 protected:
  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.session_detached_timeout_ms = 100;
    config.session_idle_timeout_ms = 400;
    config.peer_timeout_ms = 1'000;
    config.max_session_count = 2;
    return config;
  }
  ShortLivedTest() : SessionFixture(Config()) {}
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
  const auto stub = v1::LocalizationService::NewStub(ChannelWithFixedWindows(*server_.server));
  TestSession stuck(*stub);
  Open(stuck, OpenMessage());
  std::thread writer([&] {
    for (int i = 0; stuck.Send(ScanMessage(i, 2000)); ++i) {
    }
  });
  EXPECT_TRUE(Eventually([&] { return State().session_count() == 0; }));
  writer.join();
  EXPECT_FALSE(stuck.Finish().ok());
}

class NeverReapedTest : public SessionFixture {
 protected:
  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.max_session_count = 2;
    return config;
  }
  NeverReapedTest() : SessionFixture(Config()) {}
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

}  // namespace
}  // namespace dcloc::server
