#include "server/sessions/sequence_number_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

constexpr Stamp kStart{std::chrono::hours(1000)};

TEST(SequenceNumberCheckTest, ANumberMustBeHigherThanTheLastOneLocalized) {
  SequenceNumberCheck check;
  EXPECT_EQ(check.last_localized(), -1);
  EXPECT_TRUE(check.Check(0).ok());
  check.OnLocalized(5, kStart);
  EXPECT_TRUE(check.Check(6).ok());
  const absl::Status late = check.Check(5);
  EXPECT_EQ(late.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(late.message()), HasSubstr("scan.sequence_number is 5"));
}

TEST(SequenceNumberCheckTest, GoesOnWhereAnotherSessionWas) {
  SequenceNumberCheck check;
  check.Restore(7, kStart);
  EXPECT_EQ(check.last_localized(), 7);
  EXPECT_EQ(check.last_stamp(), kStart);
  EXPECT_FALSE(check.Check(7).ok());
  EXPECT_EQ(check.OnLocalized(9, kStart), 1) << "a gap is one from there";
}

TEST(SequenceNumberCheckTest, CountsTheNumbersThatNeverCame) {
  SequenceNumberCheck check;
  EXPECT_EQ(check.OnLocalized(100, kStart), 0) << "where a session begins is no gap";
  EXPECT_EQ(check.OnDropped(102), 1);
  EXPECT_EQ(check.OnLocalized(103, kStart), 0);
  EXPECT_EQ(check.OnLocalized(110, kStart), 6);
  EXPECT_EQ(check.OnDropped(105), 0);
  EXPECT_EQ(check.last_localized(), 110);
}

}  // namespace
}  // namespace dcloc::server
