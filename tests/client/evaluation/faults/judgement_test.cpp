#include "client/evaluation/faults/judgement.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dcloc::faults {
namespace {

using State = LocalizationState;

/// Ten answers a second, written down one after the other.
class Answers {
 public:
  Answers& Say(int count, State state, double error_m, double nees = 3.0) {
    for (int i = 0; i < count; ++i) {
      ScanOutcome& scan = outcome_.drive.scans.emplace_back();
      scan.answer.stamp = At(next_++);
      scan.answer.state = state;
      scan.error = {.translation_m = error_m, .rotation_deg = 0.1, .dof = 3, .nees = nees};
      outcome_.protection_level_m.emplace_back(level_m_);
      ++outcome_.arrived;
    }
    return *this;
  }
  Answers& Refuse(int count) {
    next_ += count;
    outcome_.arrived += static_cast<std::size_t>(count);
    outcome_.drive.refused_count += static_cast<std::size_t>(count);
    return *this;
  }
  Answers& Protect(std::optional<double> level_m) {
    level_m_ = level_m;
    return *this;
  }
  Answers& Fail(const std::string& what) {
    outcome_.failure = what;
    return *this;
  }

  static Stamp At(int index) { return Stamp(std::chrono::milliseconds(100 * index)); }
  double RightAgain(int end) const { return SecondsUntilRight(outcome_.drive.scans, At(end)); }
  const SessionOutcome& outcome() const { return outcome_; }

 private:
  SessionOutcome outcome_{.drive = {.drive = "town-1"}};
  std::optional<double> level_m_;
  int next_ = 0;
};

TEST(FaultJudgementTest, RightAgainIsASecondOfRightTracking) {
  Answers answers;
  answers.Say(20, State::kTracking, 0.1)
      .Say(5, State::kDeadReckoning, 0.1)
      .Say(8, State::kTracking, 0.1)  // not long enough
      .Say(2, State::kTracking, 2.5)
      .Say(20, State::kTracking, 0.1);
  EXPECT_EQ(answers.RightAgain(5), 0.0);
  EXPECT_NEAR(answers.RightAgain(20), 1.5, 1e-9);
  EXPECT_NEAR(answers.RightAgain(34), 0.1, 1e-9);
}

TEST(FaultJudgementTest, WhatIsRefusedIsNotRight) {
  Answers answers;
  answers.Say(25, State::kTracking, 0.1).Refuse(30).Say(5, State::kTracking, 0.1);
  EXPECT_TRUE(std::isinf(answers.RightAgain(20)));  // 5 answers on either side are no second
  answers.Say(20, State::kTracking, 0.1);
  EXPECT_NEAR(answers.RightAgain(20), 3.5, 1e-9);
}

TEST(FaultJudgementTest, CountsWhatHappensMeanwhile) {
  Answers answers;
  answers.Say(20, State::kTracking, 0.1)
      .Say(5, State::kTracking, 3.0)
      .Say(5, State::kTracking, 3.0, 99.0)
      .Refuse(4)
      .Say(6, State::kDeadReckoning, 5.0)
      .Say(20, State::kTracking, 0.2);
  const Record record = JudgeFault(answers.outcome(), {Answers::At(20), Answers::At(40)});
  EXPECT_EQ(record.cases, 1U);
  EXPECT_EQ(record.arrived, 60U);
  EXPECT_EQ(record.tally.scans, 56U);
  EXPECT_EQ(record.tally.refused, 4U);
  EXPECT_EQ(record.tally.wrong, 10U);
  EXPECT_EQ(record.tally.misleading, 5U);
  EXPECT_EQ(record.tally.flagged, 6U);
  EXPECT_EQ(record.tally.tracking, 50U);
  EXPECT_EQ(record.meanwhile_scans, 16U);
  EXPECT_EQ(record.meanwhile_tracking, 10U);
  EXPECT_EQ(record.errors_m.size(), 56U);
  EXPECT_EQ(record.meanwhile_errors_m.size(), 16U);
  EXPECT_EQ(record.tally.disturbed_nees_count, 16U);
  EXPECT_EQ(record.tally.episodes, 1U);
  EXPECT_EQ(record.tally.recovery_s, std::vector<double>{0.0});
  EXPECT_TRUE(record.failures.empty());
}

TEST(FaultJudgementTest, AFaultThatStaysHasNoRecoveryAndAMomentNoMeanwhile) {
  Answers answers;
  answers.Say(20, State::kTracking, 0.1).Say(20, State::kLost, 9.0);
  const Record stays = JudgeFault(answers.outcome(), {Answers::At(20), Stamp::max()});
  EXPECT_EQ(stays.tally.episodes, 0U);
  EXPECT_EQ(stays.meanwhile_scans, 20U);
  const Record moment = JudgeFault(answers.outcome(), {Answers::At(20), Answers::At(20)});
  EXPECT_EQ(moment.meanwhile_scans, 0U);
  EXPECT_EQ(moment.tally.episodes, 1U);
  EXPECT_TRUE(moment.tally.recovery_s.empty());
}

TEST(FaultJudgementTest, ProtectionLevelsOfTrackingAnswersAreComparedWithTheirErrors) {
  Answers answers;
  answers.Say(10, State::kTracking, 0.1)
      .Protect(1.0)
      .Say(5, State::kTracking, 0.5)
      .Say(3, State::kTracking, 1.5)
      .Say(4, State::kLost, 9.0);
  const Record record = JudgeFault(answers.outcome(), {Answers::At(0), Stamp::max()});
  EXPECT_EQ(record.stanford.answers, 8U);
  EXPECT_EQ(record.stanford.exceeded, 3U);
  EXPECT_EQ(record.stanford.counts.at({1, 0}), 3U);   // 1.26 to 1.58 m against 1 m
  EXPECT_EQ(record.stanford.counts.at({-4, 0}), 5U);  // 0.40 to 0.50 m
}

TEST(RecordTest, SurvivesItsJsonAndAddsUp) {
  Answers answers;
  answers.Protect(1.0).Say(20, State::kTracking, 0.12345).Refuse(3).Say(20, State::kLost, 9.0);
  answers.Fail("exception: no");
  const Record record = JudgeFault(answers.outcome(), {Answers::At(20), Answers::At(30)});
  const nlohmann::json json = nlohmann::json::parse(RecordToJson(record).dump());
  const auto copy = RecordFromJson(json);
  ASSERT_TRUE(copy.has_value());
  EXPECT_EQ(RecordToJson(*copy).dump(), RecordToJson(record).dump());
  EXPECT_EQ(copy->failures, std::vector<std::string>{"town-1: exception: no"});
  EXPECT_NEAR(copy->errors_m[0], 0.1235, 1e-9);
  Record sum = record;
  Merge(*copy, sum);
  EXPECT_EQ(sum.cases, 2U);
  EXPECT_EQ(sum.arrived, 86U);
  EXPECT_EQ(sum.errors_m.size(), 80U);
  EXPECT_EQ(sum.failures.size(), 2U);
  EXPECT_EQ(sum.stanford.answers, 40U);
  nlohmann::json broken = json;
  broken["errors_m"] = "many";
  EXPECT_FALSE(RecordFromJson(broken).has_value());
  broken.erase("errors_m");
  EXPECT_FALSE(RecordFromJson(broken).has_value());
}

}  // namespace
}  // namespace dcloc::faults
