#include "client/cli/localize/trust_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dcloc::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

v1::LocalizationResult ResultNumber(std::int64_t number, bool radar_used = true) {
  v1::LocalizationResult result;
  result.set_sequence_number(number);
  v1::RadarHealth* radar = result.mutable_health()->add_radars();
  radar->set_radar_id("front");
  radar->set_used(radar_used);
  radar->set_fault(radar_used ? v1::SOURCE_FAULT_NONE : v1::SOURCE_FAULT_MOUNT);
  return result;
}

TEST(TrustSummaryTest, SaysOnceWhatChanges) {
  TrustSummary summary;
  EXPECT_EQ(summary.Add(ResultNumber(1)), "");
  EXPECT_EQ(summary.Add(ResultNumber(2, false)), "scan 2: without radar front (mount)");
  EXPECT_EQ(summary.Add(ResultNumber(3, false)), "");
  v1::LocalizationResult jump = ResultNumber(4);
  jump.mutable_resets()->set_count(1);
  jump.mutable_resets()->mutable_last_jump()->mutable_translation_m()->set_x(2.5);
  EXPECT_EQ(summary.Add(jump), "scan 4: all sources are used; the pose jumped by 2.50 m");
  jump.set_sequence_number(5);
  EXPECT_EQ(summary.Add(jump), "");
  EXPECT_THAT(summary.Text(), AllOf(HasSubstr("2 of 5 answers are without radar front (mount)"),
                                    HasSubstr("jumped 1 times")));
  EXPECT_EQ(summary.Json()["set_aside"]["radar front (mount)"], 2);
  EXPECT_EQ(summary.Json()["reset_count"], 1);
  EXPECT_TRUE(summary.Json()["protection_level_m"].is_null());
}

TEST(TrustSummaryTest, CountsFixesByUseAndQuotesTheFirstRefusal) {
  TrustSummary summary;
  EXPECT_EQ(summary.Text(), "");
  v1::PositionFixAnswer answer;
  answer.set_use(v1::FIX_USE_FUSED);
  summary.Add(answer);
  summary.Add(answer);
  answer.set_use(v1::FIX_USE_INVALID);
  answer.set_message("no anchor");
  summary.Add(answer);
  EXPECT_THAT(summary.Text(), AllOf(HasSubstr("2 fused, 1 invalid"), HasSubstr("no anchor")));
  EXPECT_EQ(summary.Json()["fixes"]["fused"], 2);
  EXPECT_EQ(summary.Json()["first_invalid_fix"], "no anchor");
}

TEST(TrustSummaryTest, ProtectionLevelsHaveTheirQuantiles) {
  TrustSummary summary;
  for (int i = 0; i < 100; ++i) {
    v1::LocalizationResult result = ResultNumber(i);
    result.set_protection_level_m(0.01 * i);
    summary.Add(result);
  }
  summary.Add(ResultNumber(100));
  const auto levels = summary.Json()["protection_level_m"];
  EXPECT_EQ(levels["count"], 100);
  EXPECT_NEAR(levels["median"], 0.5, 0.011);
  EXPECT_NEAR(levels["p99"], 0.98, 0.011);
  EXPECT_THAT(summary.Text(), HasSubstr("100 of 101 answers have a protection level"));
}

}  // namespace
}  // namespace dcloc::cli
