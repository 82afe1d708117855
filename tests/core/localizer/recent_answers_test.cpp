#include "core/localizer/recent_answers.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

TEST(RecentAnswersTest, TheLastOnesAreKept) {
  RecentAnswers answers;
  EXPECT_EQ(answers.Find(0), nullptr);
  for (std::uint64_t i = 1; i <= 40; ++i) {
    answers.Add(i, {.stamp = Stamp(std::chrono::nanoseconds(i))});
  }
  EXPECT_EQ(answers.Find(1), nullptr);
  ASSERT_NE(answers.Find(40), nullptr);
  EXPECT_EQ(answers.Find(40)->stamp, Stamp(std::chrono::nanoseconds(40)));
  EXPECT_NE(answers.Find(9), nullptr);
  EXPECT_EQ(answers.Find(8), nullptr);
}

}  // namespace
}  // namespace dcloc
