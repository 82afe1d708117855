#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/server/localization/session_fixture.h"

// Sequence numbers and stamps, as the contract's comments have them.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class SequenceNumberTest : public SessionFixture {};

TEST_F(SequenceNumberTest, ADuplicateIsAnsweredFromMemoryByItsNumberAlone) {
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

TEST_F(SequenceNumberTest, AGapIsLocalizedAndWhatWasSkippedIsLate) {
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

TEST_F(SequenceNumberTest, ARejectionIsRememberedToo) {
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

class ForgetfulTest : public SessionFixture {
 protected:
  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.answer_history_count = 3;
    return config;
  }
  ForgetfulTest() : SessionFixture(Config()) {}
};

TEST_F(ForgetfulTest, TheMemoryIsAsLongAsItSays) {
  TestSession session(*server_.localization);
  EXPECT_EQ(Open(session, OpenMessage()).answer_history_count(), 3);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(session.Localize(ScanMessage(i))->has_result());
  EXPECT_TRUE(session.Localize(ScanMessage(7))->from_memory());
  EXPECT_EQ(session.Localize(ScanMessage(6))->rejected().code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_TRUE(session.Localize(ScanMessage(7))->from_memory()) << "late ones push nothing out";
}

TEST_F(SequenceNumberTest, AStampFarFromTheServersClockIsAcceptedAndReported) {
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

}  // namespace
}  // namespace dcloc::server
