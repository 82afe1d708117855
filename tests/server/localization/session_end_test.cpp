#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/localization/session_fixture.h"

// Dropped scans, and what operators see and do.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class OperatedSessionTest : public SessionFixture {};

TEST_F(OperatedSessionTest, TheOldestAreDroppedOnRequestAndEachHasItsAnswer) {
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

TEST_F(OperatedSessionTest, AnOperatorEndsASession) {
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

TEST_F(OperatedSessionTest, AWatcherSeesTheAnswersUntilTheEnd) {
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
    EXPECT_FALSE(response.has_scan()) << "nobody asked for it";
  }
  EXPECT_FALSE(watcher->Read(&response));
  EXPECT_TRUE(watcher->Finish().ok());

  Call late;
  const auto nobody = server_.admin->WatchSession(&late, request);
  EXPECT_FALSE(nobody->Read(&response));
  EXPECT_EQ(nobody->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(OperatedSessionTest, AWatcherWhoIsTooSlowMissesSomeAndIsToldHowMany) {
  const auto session = Connect();
  const v1::SessionOpened opened = Open(*session, ResumableOpen());
  Call call;
  v1::WatchSessionRequest request;
  request.set_session_id(opened.session_id());
  request.set_scans(true);
  const auto admin = v1::AdminService::NewStub(ChannelWithFixedWindows(*server_.server));
  const auto watcher = admin->WatchSession(&call, request);
  watcher->WaitForInitialMetadata();
  constexpr int kScans = 2000;  // more than the connection's buffers hold
  for (int i = 0; i < kScans; ++i) ASSERT_TRUE(session->Localize(ScanMessage(i, 1)).has_value());
  ASSERT_TRUE(End(opened.session_id(), "").ok());
  v1::WatchSessionResponse response;
  int seen_count = 0;
  int rig_count = 0;
  while (watcher->Read(&response)) {
    ++seen_count;
    rig_count += response.has_rig() ? 1 : 0;
  }
  EXPECT_EQ(rig_count, 1);
  EXPECT_GT(response.missed_answer_count(), 0);
  EXPECT_EQ(seen_count + response.missed_answer_count(), kScans);
}

TEST_F(OperatedSessionTest, ADrainingServerTellsWhoCanMoveAndEndsTheRest) {
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
