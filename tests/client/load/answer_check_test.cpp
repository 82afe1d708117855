#include "client/load/answer_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace dcloc::load {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kMapVersion = 3;

class AnswerCheckTest : public ::testing::Test {
 protected:
  AnswerCheckTest() {
    scan_.set_sequence_number(7);
    scan_.set_stamp_ns(1'000);
    v1::LocalizationResult& result = *answer_.mutable_result();
    result.set_sequence_number(7);
    result.set_stamp_ns(1'000);
    result.set_map_version(kMapVersion);
    result.set_state(v1::LOCALIZATION_STATE_TRACKING);
    result.mutable_pose()->mutable_pose()->mutable_translation_m()->set_x(10.0);
    result.mutable_pose()->mutable_pose()->mutable_rotation()->set_w(1.0);
    for (int i = 0; i < 36; ++i) result.mutable_pose()->add_covariance(i % 7 == 0 ? 0.01 : 0.0);
  }

  std::string Fault(Sending sending = Sending::kOnce, bool resent = false) const {
    return FaultOf(answer_, {.scan = &scan_, .sending = sending, .resent = resent}, kMapVersion)
        .value_or("none");
  }
  v1::LocalizationResult& result() { return *answer_.mutable_result(); }

  v1::Scan scan_;
  v1::LocalizeResponse answer_;
};

TEST_F(AnswerCheckTest, AGoodAnswerHasNoFault) { EXPECT_EQ(Fault(), "none"); }

TEST_F(AnswerCheckTest, AnotherScansAnswerIsAFault) {
  result().set_sequence_number(8);
  EXPECT_EQ(Fault(), "scan 8 was answered when 7 was due");
}

TEST_F(AnswerCheckTest, StampAndMapVersionMustBeTheScans) {
  result().set_stamp_ns(2'000);
  EXPECT_THAT(Fault(), HasSubstr("stamp"));
  result().set_stamp_ns(1'000);
  result().set_map_version(4);
  EXPECT_THAT(Fault(), HasSubstr("map version is 4"));
}

TEST_F(AnswerCheckTest, ThePoseMustBeOne) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  result().mutable_pose()->mutable_pose()->mutable_translation_m()->set_y(nan);
  EXPECT_THAT(Fault(), HasSubstr("position"));
  result().mutable_pose()->mutable_pose()->mutable_translation_m()->set_y(0.0);
  result().mutable_pose()->mutable_pose()->mutable_rotation()->set_w(nan);
  EXPECT_THAT(Fault(), HasSubstr("rotation"));
  result().mutable_pose()->mutable_pose()->mutable_rotation()->set_w(1.0);
  result().mutable_pose()->set_covariance(3, nan);
  EXPECT_THAT(Fault(), HasSubstr("covariance is not finite"));
  result().mutable_pose()->add_covariance(0.0);
  EXPECT_THAT(Fault(), HasSubstr("37 values"));
}

TEST_F(AnswerCheckTest, ARepeatedScanIsAnsweredFromMemory) {
  EXPECT_THAT(Fault(Sending::kDuplicate), HasSubstr("a second time"));
  answer_.set_from_memory(true);
  EXPECT_EQ(Fault(Sending::kDuplicate), "none");
  EXPECT_EQ(Fault(Sending::kOnce, /*resent=*/true), "none");
  EXPECT_THAT(Fault(Sending::kOnce), HasSubstr("from memory"));
}

TEST_F(AnswerCheckTest, OnlyALateScanIsRefusedAsLate) {
  EXPECT_THAT(Fault(Sending::kReordered), HasSubstr("not refused"));
  answer_.mutable_rejected()->set_sequence_number(7);
  answer_.mutable_rejected()->set_code(11);
  EXPECT_EQ(Fault(Sending::kReordered), "none");
  EXPECT_THAT(Fault(), HasSubstr("in order"));
  answer_.mutable_rejected()->set_code(3);
  EXPECT_EQ(Fault(), "none") << "counted as refused, which the contract allows for";
}

TEST_F(AnswerCheckTest, TheErrorIsJudgedWhereTheAnswerClaimsAPose) {
  const auto near = ErrorOf(result(), {10.0, 1.0});
  ASSERT_TRUE(near.has_value());
  EXPECT_DOUBLE_EQ(near->distance_m, 1.0);
  EXPECT_FALSE(near->misleading) << "outside of the ellipse, but near";
  EXPECT_TRUE(ErrorOf(result(), {10.0, 3.0})->misleading);
  for (const int i : {0, 7}) result().mutable_pose()->set_covariance(i, 4.0);
  EXPECT_FALSE(ErrorOf(result(), {10.0, 3.0})->misleading) << "it owns up to it";
  result().set_state(v1::LOCALIZATION_STATE_DEAD_RECKONING);
  EXPECT_FALSE(ErrorOf(result(), {10.0, 3.0}).has_value());
}

}  // namespace
}  // namespace dcloc::load
