#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <thread>

#include "tests/server/localization/session_fixture.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// The stub localizer: what is tested here is the path of fixes through a stream.
class PositionFixTest : public SessionFixture {};

TEST_F(PositionFixTest, ScansAndFixesAreAnsweredInTheOrderInWhichTheyCame) {
  const auto session = Connect();
  EXPECT_TRUE(Open(*session, OpenMessage()).takes_position_fixes());
  ASSERT_TRUE(session->Send(FixMessage(0)));
  ASSERT_TRUE(session->Send(ScanMessage(0)));
  ASSERT_TRUE(session->Send(FixMessage(1)));
  ASSERT_TRUE(session->Send(FixMessage(2)));
  ASSERT_TRUE(session->Send(ScanMessage(1)));
  session->CloseSending();
  EXPECT_EQ(session->Read()->position_fix_answer().stamp_ns(), FixMessage(0).stamp_ns());
  EXPECT_EQ(session->Read()->result().sequence_number(), 0);
  const auto answer = session->Read();
  EXPECT_EQ(answer->position_fix_answer().stamp_ns(), FixMessage(1).stamp_ns());
  EXPECT_EQ(answer->position_fix_answer().use(), v1::FIX_USE_CONTRADICTED) << "by the stub";
  EXPECT_EQ(session->Read()->position_fix_answer().stamp_ns(), FixMessage(2).stamp_ns());
  EXPECT_EQ(session->Read()->result().sequence_number(), 1);
  EXPECT_FALSE(session->Read().has_value());
  EXPECT_TRUE(session->Finish().ok());
}

TEST_F(PositionFixTest, ABadFixIsAnsweredAndTheSessionGoesOn) {
  const auto session = Connect();
  Open(*session, OpenMessage());
  v1::PositionFix satellite = FixMessage(1);
  *satellite.mutable_gnss_fix() = GnssFixMessage();
  v1::PositionFix endless = FixMessage(1);
  endless.mutable_map_pose()->set_covariance(0, std::numeric_limits<double>::infinity());
  for (const auto& [fix, field] : {std::pair(v1::PositionFix(), "position_fix.stamp_ns"),
                                   std::pair(satellite, "position_fix.gnss_fix"),
                                   std::pair(endless, "position_fix.map_pose.covariance[0]")}) {
    ASSERT_TRUE(session->Send(fix));
    const auto answer = session->Read();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->position_fix_answer().use(), v1::FIX_USE_INVALID);
    EXPECT_EQ(answer->position_fix_answer().stamp_ns(), fix.stamp_ns());
    EXPECT_THAT(answer->position_fix_answer().message(), HasSubstr(field));
  }
  EXPECT_TRUE(session->Localize(ScanMessage(1))->has_result());
}

TEST_F(PositionFixTest, ManyFixesAreBoundedAndCountedApartFromScans) {
  const auto session = Connect();
  const std::string id = Open(*session, OpenMessage()).session_id();
  constexpr int kFixes = 2000;  // far more than a session has slots
  std::thread writer([&] {
    for (int i = 0; i < kFixes; ++i) ASSERT_TRUE(session->Send(FixMessage(i)));
    ASSERT_TRUE(session->Send(ScanMessage(0)));
  });
  for (int i = 0; i < kFixes; ++i) ASSERT_TRUE(session->Read()->has_position_fix_answer());
  EXPECT_TRUE(session->Read()->has_result());
  writer.join();
  EXPECT_EQ(Get(id).position_fix_count(), kFixes);
  EXPECT_EQ(Get(id).scan_count(), 1);
  EXPECT_EQ(State().scan_count(), 1);
}

TEST_F(PositionFixTest, ASessionListsTheHealthOfItsLastAnswer) {
  const auto session = Connect();
  const std::string id = Open(*session, OpenMessage()).session_id();
  EXPECT_FALSE(Get(id).has_health());
  const auto answer = session->Localize(ScanMessage(0));
  ASSERT_EQ(answer->result().health().radars_size(), 1);
  EXPECT_EQ(answer->result().health().radars(0).radar_id(), "front");
  EXPECT_EQ(Get(id).health().SerializeAsString(), answer->result().health().SerializeAsString());
}

TEST_F(PositionFixTest, AWatcherGetsTheAnswersToFixesWhereItAsksForThem) {
  const auto session = Connect();
  v1::WatchSessionRequest request;
  request.set_session_id(Open(*session, OpenMessage()).session_id());
  Call plain_call;
  const auto plain = server_.admin->WatchSession(&plain_call, request);
  request.set_position_fixes(true);
  Call full_call;
  const auto full = server_.admin->WatchSession(&full_call, request);
  plain->WaitForInitialMetadata();
  full->WaitForInitialMetadata();
  ASSERT_TRUE(session->Send(FixMessage(0)));
  ASSERT_TRUE(session->Read()->has_position_fix_answer());
  ASSERT_TRUE(session->Localize(ScanMessage(0))->has_result());
  v1::WatchSessionResponse response;
  ASSERT_TRUE(plain->Read(&response));
  EXPECT_TRUE(response.answer().has_result());
  ASSERT_TRUE(full->Read(&response));
  EXPECT_EQ(response.answer().position_fix_answer().stamp_ns(), FixMessage(0).stamp_ns());
  plain_call.TryCancel();
  full_call.TryCancel();
}

TEST_F(PositionFixTest, AFixIsNeverAnsweredFromMemory) {
  const auto first = Connect();
  const std::string token = Open(*first, ResumableOpen()).resume_token();
  ASSERT_TRUE(first->Localize(ScanMessage(0))->has_result());
  ASSERT_TRUE(first->Send(FixMessage(0)));
  ASSERT_TRUE(first->Read()->has_position_fix_answer());
  first->Cancel();
  WaitUntilDetached();
  const auto second = Connect();
  EXPECT_EQ(Open(*second, ResumeOpen(token)).last_sequence_number(), 0);
  EXPECT_TRUE(second->Localize(ScanMessage(0))->from_memory());
  ASSERT_TRUE(second->Send(FixMessage(0)));
  const auto answer = second->Read();
  EXPECT_TRUE(answer->has_position_fix_answer());
  EXPECT_FALSE(answer->from_memory());
}

}  // namespace
}  // namespace dcloc::server
