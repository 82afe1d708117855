#include "server/sessions/scan_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

constexpr Stamp kStart{std::chrono::hours(1000)};

TEST(ScanOrderTest, ANumberMustBeHigherThanTheLastOneLocalized) {
  ScanOrder order;
  EXPECT_EQ(order.last_localized(), -1);
  EXPECT_TRUE(order.Check(0).ok());
  order.OnLocalized(5, kStart);
  EXPECT_TRUE(order.Check(6).ok());
  const absl::Status late = order.Check(5);
  EXPECT_EQ(late.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(late.message()), HasSubstr("scan.sequence_number is 5"));
}

TEST(ScanOrderTest, GoesOnWhereAnotherSessionWas) {
  ScanOrder order;
  order.Restore(7, kStart);
  EXPECT_EQ(order.last_localized(), 7);
  EXPECT_EQ(order.last_stamp(), kStart);
  EXPECT_FALSE(order.Check(7).ok());
  EXPECT_EQ(order.OnLocalized(9, kStart), 1) << "a gap is one from there";
}

TEST(ScanOrderTest, CountsTheNumbersThatNeverCame) {
  ScanOrder order;
  EXPECT_EQ(order.OnLocalized(100, kStart), 0) << "where a session begins is no gap";
  EXPECT_EQ(order.OnDropped(102), 1);
  EXPECT_EQ(order.OnLocalized(103, kStart), 0);
  EXPECT_EQ(order.OnLocalized(110, kStart), 6);
  EXPECT_EQ(order.OnDropped(105), 0);
  EXPECT_EQ(order.last_localized(), 110);
}

}  // namespace
}  // namespace dcloc::server
