#include "client/sdk/outbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dcloc::client {
namespace {

using ::testing::HasSubstr;

void PushScan(Outbox& outbox, std::int64_t number) {
  v1::Scan scan;
  scan.set_sequence_number(number);
  outbox.Push(scan);
}

void PushFix(Outbox& outbox, std::int64_t stamp_ns) {
  v1::PositionFix fix;
  fix.set_stamp_ns(stamp_ns);
  outbox.Push(fix);
}

v1::LocalizeResponse ScanAnswered(std::int64_t number) {
  v1::LocalizeResponse answer;
  answer.mutable_result()->set_sequence_number(number);
  return answer;
}

v1::LocalizeResponse FixAnswered(std::int64_t stamp_ns) {
  v1::LocalizeResponse answer;
  answer.mutable_position_fix_answer()->set_stamp_ns(stamp_ns);
  return answer;
}

TEST(OutboxTest, ScansAndFixesGoAndAreAnsweredInTheirOrder) {
  Outbox outbox;
  PushScan(outbox, 1);
  PushFix(outbox, 10);
  PushScan(outbox, 2);
  EXPECT_EQ(outbox.Next()->scan().sequence_number(), 1);
  outbox.MarkSent();
  EXPECT_EQ(outbox.Next()->position_fix().stamp_ns(), 10);
  outbox.MarkSent();
  EXPECT_EQ(outbox.scan_count(), 2U);
  EXPECT_EQ(outbox.sent_scan_count(), 1U);
  EXPECT_EQ(outbox.waiting_scan_count(), 1U);
  EXPECT_EQ(outbox.fix_count(), 1U);
  EXPECT_TRUE(outbox.TakeAnswer(ScanAnswered(1))->has_scan());
  EXPECT_TRUE(outbox.TakeAnswer(FixAnswered(10))->has_position_fix());
  EXPECT_EQ(outbox.fix_count(), 0U);
  EXPECT_THAT(std::string(outbox.TakeAnswer(ScanAnswered(2)).status().message()),
              HasSubstr("scan 2, and none was due"));
}

TEST(OutboxTest, AnAnswerOutOfTurnIsNamed) {
  Outbox outbox;
  PushFix(outbox, 10);
  outbox.MarkSent();
  EXPECT_THAT(std::string(outbox.TakeAnswer(ScanAnswered(1)).status().message()),
              HasSubstr("answered scan 1; the fix of 10 was due"));
  EXPECT_THAT(std::string(outbox.TakeAnswer(FixAnswered(11)).status().message()),
              HasSubstr("answered the fix of 11; the fix of 10 was due"));
}

TEST(OutboxTest, ANewStreamGetsTheScansAgainAndOfFixesOnlyThoseThatWaited) {
  Outbox outbox;
  PushScan(outbox, 1);
  PushFix(outbox, 10);
  PushScan(outbox, 2);
  PushFix(outbox, 20);
  for (int i = 0; i < 3; ++i) outbox.MarkSent();
  EXPECT_EQ(outbox.Rewind(), 1U);
  for (const std::int64_t number : {1, 2}) {
    EXPECT_EQ(outbox.Next()->scan().sequence_number(), number);
    outbox.MarkSent();
  }
  EXPECT_EQ(outbox.Next()->position_fix().stamp_ns(), 20);
  EXPECT_EQ(outbox.Rewind(), 0U);
  EXPECT_EQ(outbox.DropFixes(), 1U);
  EXPECT_EQ(outbox.scan_count(), 2U);
  EXPECT_EQ(outbox.fix_count(), 0U);
}

}  // namespace
}  // namespace dcloc::client
