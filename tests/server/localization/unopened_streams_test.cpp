#include "server/localization/unopened_streams.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// Streams are only told apart here.
LocalizeStream* Stream(std::uintptr_t number) { return reinterpret_cast<LocalizeStream*>(number); }

constexpr UnopenedStreams::Bounds kBounds{.total = 4, .group = 2};

TEST(UnopenedStreamsTest, TheOldestOfAFullGroupGoes) {
  UnopenedStreams streams;
  EXPECT_FALSE(streams.Add(Stream(1), "car-1", kBounds));
  EXPECT_FALSE(streams.Add(Stream(2), "car-1", kBounds));
  EXPECT_FALSE(streams.Add(Stream(3), "car-2", kBounds));
  const auto excess = streams.Add(Stream(4), "car-1", kBounds);
  ASSERT_TRUE(excess);
  EXPECT_EQ(excess->stream, Stream(1));
  EXPECT_THAT(excess->reason, HasSubstr("max_unopened_stream_count_per_peer is 2"));
  EXPECT_EQ(streams.count(), 3);
}

TEST(UnopenedStreamsTest, WhenAllAreTooManyTheLargestGroupLosesItsOldest) {
  UnopenedStreams streams;
  EXPECT_FALSE(streams.Add(Stream(1), "car-1", {.total = 3}));
  EXPECT_FALSE(streams.Add(Stream(2), "stranger", {.total = 3}));
  EXPECT_FALSE(streams.Add(Stream(3), "stranger", {.total = 3}));
  const auto excess = streams.Add(Stream(4), "car-2", {.total = 3});
  ASSERT_TRUE(excess);
  EXPECT_EQ(excess->stream, Stream(2)) << "not the one that has just come, nor a lone one";
  EXPECT_THAT(excess->reason, HasSubstr("max_unopened_stream_count is 3"));
}

TEST(UnopenedStreamsTest, OneThatIsKnownCountsForItsPrincipal) {
  UnopenedStreams streams;
  EXPECT_FALSE(streams.Add(Stream(1), "192.0.2.1", kBounds));
  EXPECT_FALSE(streams.Add(Stream(2), "192.0.2.1", kBounds));
  EXPECT_FALSE(streams.Move(Stream(1), "car-1", kBounds));
  EXPECT_FALSE(streams.Add(Stream(3), "192.0.2.1", kBounds)) << "there is room again";
  streams.Remove(Stream(1));
  streams.Remove(Stream(1));
  EXPECT_EQ(streams.count(), 2);
  EXPECT_FALSE(streams.Move(Stream(1), "car-2", kBounds)) << "it is not here any more";
  EXPECT_EQ(streams.count(), 2);
}

}  // namespace
}  // namespace dcloc::server
