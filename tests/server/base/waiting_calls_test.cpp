#include "server/base/waiting_calls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

struct Stream {};
using Streams = WaitingCalls<Stream>;

constexpr WaitingBounds kBounds{.total = 4, .group = 2};

TEST(WaitingCallsTest, TheOldestOfAFullGroupGoes) {
  std::array<Stream, 5> calls;
  Streams streams;
  EXPECT_FALSE(streams.Add(&calls[1], "car-1", kBounds));
  EXPECT_FALSE(streams.Add(&calls[2], "car-1", kBounds));
  EXPECT_FALSE(streams.Add(&calls[3], "car-2", kBounds));
  const auto excess = streams.Add(&calls[4], "car-1", kBounds);
  ASSERT_TRUE(excess);
  EXPECT_EQ(excess->call, &calls[1]);
  EXPECT_THAT(excess->reason, HasSubstr("max_unopened_stream_count_per_peer is 2"));
  EXPECT_EQ(streams.count(), 3);
}

TEST(WaitingCallsTest, WhenAllAreTooManyTheLargestGroupLosesItsOldest) {
  std::array<Stream, 5> calls;
  Streams streams;
  EXPECT_FALSE(streams.Add(&calls[1], "car-1", {.total = 3}));
  EXPECT_FALSE(streams.Add(&calls[2], "stranger", {.total = 3}));
  EXPECT_FALSE(streams.Add(&calls[3], "stranger", {.total = 3}));
  const auto excess = streams.Add(&calls[4], "car-2", {.total = 3});
  ASSERT_TRUE(excess);
  EXPECT_EQ(excess->call, &calls[2]) << "not the one that has just come, nor a lone one";
  EXPECT_THAT(excess->reason, HasSubstr("max_unopened_stream_count is 3"));
}

TEST(WaitingCallsTest, OneThatIsKnownCountsForItsPrincipal) {
  std::array<Stream, 5> calls;
  Streams streams;
  EXPECT_FALSE(streams.Add(&calls[1], "192.0.2.1", kBounds));
  EXPECT_FALSE(streams.Add(&calls[2], "192.0.2.1", kBounds));
  EXPECT_FALSE(streams.Move(&calls[1], "car-1", kBounds));
  EXPECT_FALSE(streams.Add(&calls[3], "192.0.2.1", kBounds)) << "there is room again";
  streams.Remove(&calls[1]);
  streams.Remove(&calls[1]);
  EXPECT_EQ(streams.count(), 2);
  EXPECT_FALSE(streams.Move(&calls[1], "car-2", kBounds)) << "it is not here any more";
  EXPECT_EQ(streams.count(), 2);
}

}  // namespace
}  // namespace dcloc::server
