#include "client/cli/remote/answer_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dcloc::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(AgeTextTest, HasAFittingUnit) {
  EXPECT_EQ(AgeText(0.25), "250 ms");
  EXPECT_EQ(AgeText(30.0), "30 s");
  EXPECT_EQ(AgeText(600.0), "10 min");
  EXPECT_EQ(AgeText(36000.0), "10 h");
}

v1::Health OneMissing() {
  v1::Health health;
  health.mutable_wheel_speed()->set_fault(v1::SOURCE_FAULT_SILENT);
  health.mutable_yaw_rate()->set_used(true);
  health.mutable_yaw_rate()->set_fault(v1::SOURCE_FAULT_BIAS);
  v1::RadarHealth* radar = health.add_radars();
  radar->set_radar_id("front");
  radar->set_fault(v1::SOURCE_FAULT_MOUNT);
  return health;
}

TEST(AnswerTextTest, NamesTheSourcesThatAreSetAsideWithTheirFaults) {
  EXPECT_EQ(SetAsideText(OneMissing()), "radar front (mount)")
      << "who says nothing is not missed, and who is corrected is used";
  EXPECT_EQ(HealthJson(OneMissing())["radars"]["front"]["fault"], "mount");
  EXPECT_EQ(HealthJson(OneMissing())["yaw_rate"]["used"], true);
}

TEST(AnswerTextTest, AnAnswerHasWhatItIsWorth) {
  v1::LocalizeResponse answer;
  EXPECT_TRUE(AnswerJson(answer)["protection_level_m"].is_null());
  answer.mutable_result()->set_protection_level_m(0.5);
  answer.mutable_result()->mutable_resets()->set_count(2);
  *answer.mutable_result()->mutable_health() = OneMissing();
  EXPECT_THAT(AnswerLine(answer), AllOf(HasSubstr("(<= 0.50 m)"), HasSubstr("2 resets"),
                                        HasSubstr("without radar front (mount)")));
  EXPECT_EQ(AnswerJson(answer)["protection_level_m"], 0.5);
  EXPECT_EQ(AnswerJson(answer)["reset_count"], 2);
}

TEST(AnswerTextTest, AFixHasItsUseAndTheReason) {
  v1::LocalizeResponse answer;
  answer.mutable_position_fix_answer()->set_stamp_ns(1'500'000'000);
  answer.mutable_position_fix_answer()->set_use(v1::FIX_USE_INVALID);
  answer.mutable_position_fix_answer()->set_message("x is nan");
  EXPECT_THAT(AnswerLine(answer), HasSubstr("1.500000000: invalid, x is nan"));
  EXPECT_EQ(AnswerJson(answer)["use"], "invalid");
}

}  // namespace
}  // namespace dcloc::cli
