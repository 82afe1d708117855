#include "core/localizer/time_base.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dcloc {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;
using ::testing::HasSubstr;

Stamp At(std::chrono::nanoseconds since) { return Stamp(seconds(1'700'000'000)) + since; }

TEST(TimeBaseTest, ScansInOrderKeepTheirStamps) {
  TimeBase time;
  for (int i = 0; i < 100; ++i) {
    const auto taken = time.ToMonotonic(At(milliseconds(77 * i)));
    ASSERT_TRUE(taken.ok());
    EXPECT_EQ(taken->stamp, At(milliseconds(77 * i)));
    EXPECT_FALSE(taken->is_late);
    EXPECT_FALSE(taken->clock_was_set);
  }
  EXPECT_TRUE(time.ToMonotonic(At(milliseconds(77 * 99))).ok()) << "two radars may share a stamp";
}

TEST(TimeBaseTest, LateScansAreTakenAtTheirStamp) {
  TimeBase time;
  ASSERT_TRUE(time.ToMonotonic(At(milliseconds(1000))).ok());
  for (const int late_ms : {1, 60, 250}) {
    const auto taken = time.ToMonotonic(At(milliseconds(1000 - late_ms)));
    ASSERT_TRUE(taken.ok()) << late_ms;
    EXPECT_TRUE(taken->is_late);
    EXPECT_EQ(taken->stamp, At(milliseconds(1000 - late_ms)));
  }
}

TEST(TimeBaseTest, AScanThatIsTooLateIsRefusedWithItsStamp) {
  TimeBase time;
  ASSERT_TRUE(time.ToMonotonic(At(milliseconds(1000))).ok());
  const auto refused = time.ToMonotonic(At(milliseconds(749)));
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.status().message()),
              HasSubstr(std::to_string(At(milliseconds(749)).time_since_epoch().count())));
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("250 ms"));
}

class ClockTest : public ::testing::TestWithParam<std::chrono::nanoseconds> {};

TEST_P(ClockTest, SetBackCostsTwoScansAndTimeGoesOn) {
  TimeBase time;
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(time.ToMonotonic(At(milliseconds(77 * i))).ok());
  Stamp newest = At(milliseconds(77 * 9));
  int refused = 0;
  bool was_set = false;
  for (int i = 10; i < 40; ++i) {
    const auto taken = time.ToMonotonic(At(milliseconds(77 * i)) - GetParam());
    if (!taken.ok()) {
      ++refused;
      continue;
    }
    was_set = was_set || taken->clock_was_set;
    EXPECT_GE(taken->stamp, newest);
    EXPECT_LE(taken->stamp - newest, milliseconds(200));
    newest = taken->stamp;
  }
  EXPECT_EQ(refused, 2);
  EXPECT_TRUE(was_set);
}

INSTANTIATE_TEST_SUITE_P(By, ClockTest,
                         ::testing::Values(milliseconds(900), seconds(5), minutes(10),
                                           std::chrono::hours(24 * 365)));

TEST(TimeBaseTest, AClockThatIsAheadForAMomentCostsTwoScans) {
  TimeBase time;
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    const auto ahead = i >= 20 && i < 25 ? minutes(10) : minutes(0);
    if (!time.ToMonotonic(At(milliseconds(77 * i)) + ahead).ok()) ++refused;
  }
  EXPECT_EQ(refused, 2);
}

TEST(TimeBaseTest, OldScansNowAndThenAreNoNewTime) {
  TimeBase time;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(time.ToMonotonic(At(seconds(10) + milliseconds(77 * i))).ok());
    EXPECT_FALSE(time.ToMonotonic(At(milliseconds(77 * i))).ok());
    EXPECT_FALSE(time.ToMonotonic(At(seconds(3) - milliseconds(900 * i))).ok());
  }
}

TEST(TimeBaseTest, AYearOfSilenceIsAMinute) {
  TimeBase time;
  ASSERT_TRUE(time.ToMonotonic(At(seconds(0))).ok());
  const auto taken = time.ToMonotonic(At(std::chrono::hours(24 * 365)));
  ASSERT_TRUE(taken.ok());
  EXPECT_EQ(taken->stamp, At(minutes(1)));
  EXPECT_EQ(time.ToMonotonic(At(std::chrono::hours(24 * 365) + milliseconds(77)))->stamp,
            At(minutes(1) + milliseconds(77)));
}

}  // namespace
}  // namespace dcloc
