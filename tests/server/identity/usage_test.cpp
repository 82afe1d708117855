#include "server/identity/usage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr RateLimit::Clock::time_point kNow{std::chrono::hours(1)};

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
  EXPECT_TRUE(first->ChargeScan(10, kNow).ok());
  EXPECT_TRUE(second->ChargeScan(10, kNow).ok());
  EXPECT_TRUE(first->ChargeScan(10, kNow).ok());
  const absl::Status status = second->ChargeScan(10, kNow);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("max_scan_rate_hz_per_principal, which is 3"));
}

TEST_F(UsageTest, FixesHaveTheRateOfScansToThemselves) {
  limits_.max_scan_rate_hz_per_principal = 2;
  const auto permit = *usages_.TakeSession(car_);
  EXPECT_TRUE(permit->ChargeFix(kNow).ok());
  EXPECT_TRUE(permit->ChargeFix(kNow).ok());
  const absl::Status status = permit->ChargeFix(kNow);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(
      std::string(status.message()),
      AllOf(HasSubstr("position fixes"), HasSubstr("max_scan_rate_hz_per_principal, which is 2")));
  EXPECT_TRUE(permit->ChargeScan(10, kNow).ok());
}

TEST_F(UsageTest, TargetsOfAScanAreBounded) {
  limits_.max_target_count = 100;
  const auto permit = *usages_.TakeSession(car_);
  EXPECT_TRUE(permit->ChargeScan(100, kNow).ok());
  const absl::Status status = permit->ChargeScan(101, kNow);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr("101 targets"), HasSubstr("max_target_count is 100")));
}

}  // namespace
}  // namespace dcloc::server
