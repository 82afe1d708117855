#include "server/sessions/answer_history.h"

#include <gtest/gtest.h>

namespace dcloc::server {
namespace {

ScanAnswer RejectedAnswer(std::int64_t sequence_number, const char* message = "no") {
  return {.sequence_number = sequence_number, .result = absl::InvalidArgumentError(message)};
}

TEST(AnswerHistoryTest, IsAsLongAsItSays) {
  AnswerHistory history(3);
  EXPECT_EQ(history.Recall(0), nullptr);
  for (int i = 0; i < 5; ++i) history.Keep(RejectedAnswer(i));
  EXPECT_EQ(history.Recall(1), nullptr);
  for (int i = 2; i < 5; ++i) {
    ASSERT_NE(history.Recall(i), nullptr) << i;
    EXPECT_EQ(history.Recall(i)->sequence_number, i);
  }
}

TEST(AnswerHistoryTest, GivesTheNewestOfANumber) {
  AnswerHistory history(3);
  history.Keep(RejectedAnswer(1, "first"));
  history.Keep(RejectedAnswer(1, "second"));
  EXPECT_EQ(history.Recall(1)->result.status().message(), "second");
}

TEST(AnswerHistoryTest, GivesAResultAsItWas) {
  AnswerHistory history(1);
  LocalizedScan scan{.map_version = 9};
  scan.localization.covariance(0, 5) = 0.25;
  history.Keep({.sequence_number = 1, .result = scan, .dropped_scan_count = 4});
  const ScanAnswer* answer = history.Recall(1);
  ASSERT_NE(answer, nullptr);
  EXPECT_EQ(answer->result->map_version, 9);
  EXPECT_EQ(answer->result->localization.covariance(0, 5), 0.25);
  EXPECT_EQ(answer->dropped_scan_count, 4);
}

}  // namespace
}  // namespace dcloc::server
