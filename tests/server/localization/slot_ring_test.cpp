#include "server/localization/slot_ring.h"

#include <gtest/gtest.h>

#include "tests/server/fixtures/messages.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kSmall_bytes = 1000;

void Read(SlotRing& ring, std::int64_t sequence_number, std::size_t size_bytes = kSmall_bytes) {
  *ring.to_read().request.mutable_scan() = ScanMessage(sequence_number);
  ring.OnRead(size_bytes);
}

/// A ring whose first message, the opening, is written.
SlotRing OpenRing(int max_pending_count) {
  SlotRing ring(max_pending_count);
  ring.OnRead(kSmall_bytes);
  ring.OnAnswered();
  ring.OnWritten();
  return ring;
}

TEST(SlotRingTest, HasRoomForOneMessageBeforeTheFirstAnswer) {
  SlotRing ring(8);
  EXPECT_TRUE(ring.none_read());
  EXPECT_TRUE(ring.has_room());
  ring.OnRead(kSmall_bytes);
  EXPECT_FALSE(ring.has_room());
  EXPECT_FALSE(ring.has_answer_to_write());
  ring.OnAnswered();
  EXPECT_TRUE(ring.has_room());
  EXPECT_TRUE(ring.has_answer_to_write());
  EXPECT_FALSE(ring.any_written());
  EXPECT_FALSE(ring.all_read_is_written());
  ring.OnWritten();
  EXPECT_TRUE(ring.all_read_is_written());
}

TEST(SlotRingTest, IsFullUntilAnAnswerIsWritten) {
  SlotRing ring = OpenRing(2);
  Read(ring, 1);
  Read(ring, 2);
  EXPECT_FALSE(ring.has_room());
  EXPECT_EQ(ring.to_answer().request.scan().sequence_number(), 1);
  ring.OnAnswered();
  EXPECT_FALSE(ring.has_room());
  EXPECT_EQ(ring.to_answer().request.scan().sequence_number(), 2);
  EXPECT_EQ(ring.to_write().request.scan().sequence_number(), 1);
  ring.OnWritten();
  EXPECT_TRUE(ring.has_room());
}

TEST(SlotRingTest, WhatNeedsNoAnswerIsPassedOverInItsTurn) {
  SlotRing ring = OpenRing(3);
  for (int i = 1; i <= 3; ++i) Read(ring, i);
  for (const Handling handling : {Handling::kAnswer, Handling::kSilent, Handling::kSilent}) {
    ring.to_answer().handling = handling;
    ring.OnAnswered();
  }
  ring.PassSilent();
  EXPECT_EQ(ring.to_write().request.scan().sequence_number(), 1) << "not before its turn";
  ring.OnWritten();
  ring.PassSilent();
  EXPECT_TRUE(ring.all_read_is_written());
  EXPECT_TRUE(ring.has_room());
  Read(ring, 4);
  EXPECT_EQ(ring.newest_read().handling, Handling::kAnswer) << "the slot is used again";
}

TEST(SlotRingTest, TheOldestThatWaitAreDroppedAndLoseTheirColumns) {
  SlotRing ring = OpenRing(2);
  ring.Lengthen();
  for (int i = 1; i <= 4; ++i) {
    Read(ring, i);
    ring.DropOldest(1);
  }
  EXPECT_TRUE(ring.has_room());
  EXPECT_EQ(ring.to_answer().handling, Handling::kAnswer) << "it is being answered";
  ring.OnAnswered();
  EXPECT_EQ(ring.to_answer().handling, Handling::kDrop);
  EXPECT_EQ(ring.to_answer().request.scan().sequence_number(), 2);
  EXPECT_EQ(ring.to_answer().request.scan().range_m_size(), 0);
  ring.OnAnswered();
  EXPECT_EQ(ring.to_answer().handling, Handling::kAnswer);
  EXPECT_GT(ring.to_answer().request.scan().range_m_size(), 0);
}

TEST(SlotRingTest, FixesAreNotDroppedAndDropNothing) {
  SlotRing ring = OpenRing(2);
  ring.Lengthen();
  Read(ring, 1);
  for (int i = 0; i < 10; ++i) {
    *ring.to_read().request.mutable_position_fix() = FixMessage(1);
    ring.OnRead(kSmall_bytes);
    ring.DropOldest(0);
  }
  Read(ring, 2);
  ring.DropOldest(0);
  EXPECT_EQ(ring.to_answer().handling, Handling::kAnswer);
  Read(ring, 3);
  ring.DropOldest(0);
  EXPECT_EQ(ring.to_answer().handling, Handling::kDrop) << "three scans wait";
  ring.OnAnswered();
  EXPECT_EQ(ring.to_answer().handling, Handling::kAnswer);
  EXPECT_TRUE(ring.to_answer().request.has_position_fix());
}

TEST(SlotRingTest, WithoutOneBeingAnsweredTheFirstIsDroppedToo) {
  SlotRing ring = OpenRing(2);
  ring.Lengthen();
  for (int i = 1; i <= 3; ++i) Read(ring, i);
  ring.DropOldest(0);
  EXPECT_EQ(ring.to_answer().handling, Handling::kDrop);
}

TEST(SlotRingTest, LargeMessagesFillItSooner) {
  SlotRing ring = OpenRing(8);
  Read(ring, 1, SlotRing::kMaxWaitingBytes - 1);
  EXPECT_TRUE(ring.has_room());
  Read(ring, 2, SlotRing::kMaxWaitingBytes - 1);
  EXPECT_FALSE(ring.has_room());
  ring.OnAnswered();
  EXPECT_FALSE(ring.has_room());
  ring.OnWritten();
  EXPECT_TRUE(ring.has_room());
}

TEST(SlotRingTest, OfLargeMessagesFewerWaitBeforeTheOldestIsDropped) {
  SlotRing ring(8);
  ring.OnRead(kSmall_bytes);
  ring.Lengthen();
  ring.OnAnswered();
  ring.OnWritten();
  constexpr std::size_t kThird_bytes = SlotRing::kMaxWaitingBytes / 3;
  for (int i = 1; i <= 3; ++i) Read(ring, i, kThird_bytes);
  ring.DropOldest(0);
  EXPECT_EQ(ring.to_answer().handling, Handling::kAnswer);
  Read(ring, 4, kThird_bytes);
  EXPECT_TRUE(ring.has_room());
  ring.DropOldest(0);
  EXPECT_EQ(ring.to_answer().handling, Handling::kDrop);
  Read(ring, 5, 2 * SlotRing::kMaxWaitingBytes);
  ring.DropOldest(0);
  EXPECT_EQ(ring.newest_read().handling, Handling::kAnswer) << "the newest one is never dropped";
}

TEST(SlotRingTest, MemoryOfLargeMessagesIsNotKept) {
  SlotRing ring = OpenRing(1);
  for (const std::size_t size_bytes : {std::size_t{1} << 17, kSmall_bytes}) {
    Slot& slot = ring.to_read();
    for (int i = 0; i < 10'000; ++i) slot.request.mutable_scan()->add_range_m(1.0F);
    ring.OnRead(size_bytes);
    ring.OnAnswered();
    ring.OnWritten();
    EXPECT_EQ(slot.request.SpaceUsedLong() > 40'000, size_bytes == kSmall_bytes);
  }
}

}  // namespace
}  // namespace dcloc::server
