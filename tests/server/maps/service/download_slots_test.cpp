#include "server/maps/service/download_slots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr DownloadSlots::Bounds kSlotBounds{.total = 3, .caller = 2};

TEST(DownloadSlotsTest, ACallerHasItsShareAndOthersTheRest) {
  DownloadSlots slots;
  std::vector<std::shared_ptr<void>> held = {*slots.Take("a", kSlotBounds),
                                             *slots.Take("a", kSlotBounds)};
  const absl::Status third = slots.Take("a", kSlotBounds).status();
  EXPECT_EQ(third.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(third.ToString(), AllOf(HasSubstr("2"), HasSubstr("max_download_count_per_caller")));
  held.push_back(*slots.Take("b", kSlotBounds));
  EXPECT_EQ(slots.count(), 3);
  const absl::Status fourth = slots.Take("c", kSlotBounds).status();
  EXPECT_THAT(fourth.ToString(), AllOf(HasSubstr("3"), HasSubstr("max_download_count;")));
  held.front().reset();
  EXPECT_EQ(slots.count(), 2);
  EXPECT_TRUE(slots.Take("a", kSlotBounds).ok()) << "a slot that was given back is free";
}

TEST(DownloadSlotsTest, ASlotMayOutliveThem) {
  auto slots = std::make_unique<DownloadSlots>();
  std::shared_ptr<void> slot = *slots->Take("a", kSlotBounds);
  slots.reset();
  slot.reset();
}

TEST(DownloadSlotsTest, ABoundOfNothingRefusesAll) {
  DownloadSlots slots;
  EXPECT_FALSE(slots.Take("a", {.total = 3, .caller = 0}).ok());
  EXPECT_FALSE(slots.Take("a", {.total = 0, .caller = 3}).ok());
  EXPECT_TRUE(slots.Take("a", kSlotBounds).ok());
}

}  // namespace
}  // namespace dcloc::server
