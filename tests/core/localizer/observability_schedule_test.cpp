#include "core/localizer/observability_schedule.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSpan(1000);

Stamp At(int ms) { return Stamp(std::chrono::seconds(1000) + milliseconds(ms)); }

TEST(ObservabilityScheduleTest, OneRegistrationOfASubmapIsAsked) {
  ObservabilitySchedule schedule;
  EXPECT_TRUE(schedule.IsDue(At(0), kSpan, false)) << "the first one";
  EXPECT_FALSE(schedule.IsDue(At(500), kSpan, false));
  EXPECT_FALSE(schedule.IsDue(At(1000), kSpan, false)) << "it shares a scan";
  EXPECT_TRUE(schedule.IsDue(At(1001), kSpan, false));
}

TEST(ObservabilityScheduleTest, EachThatDecidesBetweenSourcesIsAsked) {
  ObservabilitySchedule schedule;
  EXPECT_TRUE(schedule.IsDue(At(0), kSpan, false));
  EXPECT_TRUE(schedule.IsDue(At(150), kSpan, true));
  EXPECT_TRUE(schedule.IsDue(At(300), kSpan, true));
  EXPECT_FALSE(schedule.IsDue(At(450), kSpan, false)) << "the last one is recent";
  EXPECT_TRUE(schedule.IsDue(At(1301), kSpan, false));
}

}  // namespace
}  // namespace dcloc
