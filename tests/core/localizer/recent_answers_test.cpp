#include "core/localizer/recent_answers.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

Scan ScanAt(int ms, float range_m) {
  return {.stamp = Stamp(std::chrono::milliseconds(ms)),
          .radar_id = "front",
          .range_m = {range_m, 20.0F},
          .range_rate_mps = {-3.0F, -4.0F},
          .azimuth_rad = {0.1F, 0.2F}};
}

TEST(RecentAnswersTest, TheSameScanHasTheSameFingerprintAndNoOtherHas) {
  const std::uint64_t one = RecentAnswers::Fingerprint(ScanAt(100, 10.0F));
  EXPECT_EQ(RecentAnswers::Fingerprint(ScanAt(100, 10.0F)), one);
  EXPECT_NE(RecentAnswers::Fingerprint(ScanAt(101, 10.0F)), one);
  EXPECT_NE(RecentAnswers::Fingerprint(ScanAt(100, 10.1F)), one);
  Scan other = ScanAt(100, 10.0F);
  other.radar_id = "rear";
  EXPECT_NE(RecentAnswers::Fingerprint(other), one);
  other = ScanAt(100, 10.0F);
  other.range_rate_mps[1] = -4.5F;
  EXPECT_NE(RecentAnswers::Fingerprint(other), one);
}

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
