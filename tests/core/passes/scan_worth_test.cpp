#include "core/passes/scan_worth.h"

#include <gtest/gtest.h>

#include <chrono>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

Localization Good() {
  Localization answer;
  answer.state = LocalizationState::kTracking;
  answer.covariance = 0.001 * Matrix6d::Identity();
  answer.quality.inlier_count = 100;
  const SourceHealth sound{.is_used = true, .fault = SourceFault::kNone};
  answer.health = {.wheel_speed = sound, .yaw_rate = sound, .radars = {sound, sound}};
  return answer;
}

Stamp At(int ms) { return Stamp(milliseconds(1'700'000'000'000 + ms)); }

/// Of an answer after two seconds of good ones.
ScanWorth WorthOf(const Localization& answer, std::size_t radar = 0) {
  ScanJudge judge({});
  judge.Judge(Good(), 0, At(0));
  return judge.Judge(answer, radar, At(2000));
}

TEST(ScanWorthTest, TrackingMustHaveSettled) {
  ScanJudge judge({});
  EXPECT_EQ(judge.Judge(Good(), 0, At(0)), ScanWorth::kUntracked);
  EXPECT_EQ(judge.Judge(Good(), 0, At(999)), ScanWorth::kUntracked);
  EXPECT_EQ(judge.Judge(Good(), 0, At(1000)), ScanWorth::kGood);
  Localization lost = Good();
  lost.state = LocalizationState::kLost;
  EXPECT_EQ(judge.Judge(lost, 0, At(1100)), ScanWorth::kUntracked);
  EXPECT_EQ(judge.Judge(Good(), 0, At(1200)), ScanWorth::kUntracked) << "it begins anew";
  EXPECT_EQ(judge.Judge(Good(), 0, At(2200)), ScanWorth::kGood);
}

TEST(ScanWorthTest, SourcesMustBeSound) {
  Localization answer = Good();
  answer.health.wheel_speed = {.is_used = false, .fault = SourceFault::kFrozen};
  EXPECT_EQ(WorthOf(answer), ScanWorth::kUnsound);
  answer.health.wheel_speed.fault = SourceFault::kSilent;
  EXPECT_EQ(WorthOf(answer), ScanWorth::kGood) << "a vehicle may have none";
  answer.health.radars[1] = {.is_used = false, .fault = SourceFault::kMount};
  EXPECT_EQ(WorthOf(answer, 0), ScanWorth::kGood) << "it is another radar's";
  EXPECT_EQ(WorthOf(answer, 1), ScanWorth::kUnsound);
}

TEST(ScanWorthTest, PosesMustBeSure) {
  Localization answer = Good();
  answer.quality.inlier_count = 19;
  EXPECT_EQ(WorthOf(answer), ScanWorth::kUnsure);
  answer = Good();
  answer.covariance(1, 1) = 0.31 * 0.31;
  EXPECT_EQ(WorthOf(answer), ScanWorth::kUnsure);
  EXPECT_NEAR(HorizontalSigma_m(answer.covariance), 0.31, 1e-9);
}

}  // namespace
}  // namespace dcloc
