#include "server/base/rate_limit.h"

#include <gtest/gtest.h>

#include <chrono>

namespace dcloc::server {
namespace {

constexpr RateLimit::Clock::time_point kBegin{std::chrono::hours(1)};

int CountTaken(RateLimit& limit, double rate_hz, RateLimit::Clock::time_point now) {
  int taken = 0;
  while (taken < 1000 && limit.Take(rate_hz, now)) ++taken;
  return taken;
}

TEST(RateLimitTest, HoldsASecondsWorthAndFillsAgain) {
  RateLimit limit;
  EXPECT_EQ(CountTaken(limit, 10.0, kBegin), 10);
  EXPECT_EQ(CountTaken(limit, 10.0, kBegin + std::chrono::milliseconds(250)), 2);
  EXPECT_EQ(CountTaken(limit, 10.0, kBegin + std::chrono::hours(1)), 10);
}

TEST(RateLimitTest, TimesInTheOtherOrderGiveNothing) {
  RateLimit limit;
  EXPECT_EQ(CountTaken(limit, 10.0, kBegin), 10);
  EXPECT_EQ(CountTaken(limit, 10.0, kBegin - std::chrono::hours(1)), 0);
  EXPECT_EQ(CountTaken(limit, 10.0, kBegin + std::chrono::milliseconds(100)), 1);
}

TEST(RateLimitTest, ZeroIsNoLimitAndANewRateHoldsAtOnce) {
  RateLimit limit;
  EXPECT_EQ(CountTaken(limit, 0.0, kBegin), 1000);
  EXPECT_EQ(CountTaken(limit, 5.0, kBegin), 5);
  EXPECT_EQ(CountTaken(limit, 1.0, kBegin + std::chrono::hours(1)), 1);
}

}  // namespace
}  // namespace dcloc::server
