#include "core/localizer/stamp_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace dcloc {
namespace {

Scan ScanAt(int ms, const char* radar_id) {
  return {.stamp = Stamp(std::chrono::milliseconds(ms)), .radar_id = radar_id};
}

TEST(StampOrderTest, ARadarsStampsRise) {
  StampOrder order;
  order.Accept(ScanAt(100, "front"));
  EXPECT_TRUE(order.Check(ScanAt(101, "front")).ok());
  for (const int ms : {100, 99}) {
    const absl::Status status = order.Check(ScanAt(ms, "front"));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("'front' was at 100000000 ns"));
  }
}

TEST(StampOrderTest, RadarsMayShareAStampButNotGoBack) {
  StampOrder order;
  order.Accept(ScanAt(100, "front"));
  EXPECT_TRUE(order.Check(ScanAt(100, "rear")).ok());
  const absl::Status status = order.Check(ScanAt(99, "rear"));
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("newest scan's 100000000 ns"));
}

TEST(StampOrderTest, WhatWasOnlyCheckedIsForgotten) {
  StampOrder order;
  EXPECT_TRUE(order.Check(ScanAt(100, "front")).ok());
  EXPECT_TRUE(order.Check(ScanAt(50, "front")).ok());
}

}  // namespace
}  // namespace dcloc
