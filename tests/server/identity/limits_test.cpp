#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "server/base/rate_limit.h"
#include "server/identity/usage.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

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

class UsageTest : public ::testing::Test {
 protected:
  ServerConfig config_;
  Limits limits_{config_};
  UsageCounts usages_{limits_};
  const Principal car_{.name = "car", .role = Role::kVehicle};
};

TEST_F(UsageTest, SessionsOfAPrincipalAreBoundedAndGivenBack) {
  limits_.max_session_count_per_principal = 2;
  auto first = usages_.TakeSession(car_);
  const auto second = usages_.TakeSession(car_);
  ASSERT_TRUE(first.ok() && second.ok());
  const absl::Status status = usages_.TakeSession(car_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr("\"car\""), HasSubstr("max_session_count_per_principal is 2")));
  EXPECT_TRUE(usages_.TakeSession({.name = "car", .tenant = "acme"}).ok()) << "another tenant's";
  first->reset();
  EXPECT_TRUE(usages_.TakeSession(car_).ok());
}

TEST_F(UsageTest, ScansOfAPrincipalShareOneRate) {
  limits_.max_scan_rate_hz_per_principal = 3;
  const auto first = *usages_.TakeSession(car_);
  const auto second = *usages_.TakeSession(car_);
  EXPECT_TRUE(first->TakeScan(10, kBegin).ok());
  EXPECT_TRUE(second->TakeScan(10, kBegin).ok());
  EXPECT_TRUE(first->TakeScan(10, kBegin).ok());
  const absl::Status status = second->TakeScan(10, kBegin);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("max_scan_rate_hz_per_principal, which is 3"));
}

TEST_F(UsageTest, TargetsOfAScanAreBounded) {
  limits_.max_target_count = 100;
  const auto permit = *usages_.TakeSession(car_);
  EXPECT_TRUE(permit->TakeScan(100, kBegin).ok());
  const absl::Status status = permit->TakeScan(101, kBegin);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr("101 targets"), HasSubstr("max_target_count is 100")));
}

}  // namespace
}  // namespace dcloc::server
