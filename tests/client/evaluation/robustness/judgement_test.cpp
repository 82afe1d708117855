#include "client/evaluation/robustness/judgement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace dcloc::robustness {
namespace {

using State = LocalizationState;

constexpr double kInside = 3.0;    // NEES within the 95 % ellipsoid of three degrees of freedom
constexpr double kOutside = 99.0;  // outside of the 99.9 % ellipsoid

/// A session of ten scans a second, written down answer by answer.
class Session {
 public:
  Session& Say(int count, State state, double error_m, double nees = kInside,
               double error_deg = 0.1) {
    for (int i = 0; i < count; ++i) {
      ScanOutcome& scan = outcome_.scans.emplace_back();
      scan.answer.stamp = At(next_++);
      scan.answer.state = state;
      scan.error = {.translation_m = error_m, .rotation_deg = error_deg, .dof = 3, .nees = nees};
    }
    return *this;
  }
  Session& Skip(int count) {
    next_ += count;
    return *this;
  }

  static Stamp At(int index) { return Stamp(std::chrono::milliseconds(100 * index)); }
  const DriveOutcome& outcome() const { return outcome_; }

 private:
  DriveOutcome outcome_{.drive = "drive"};
  int next_ = 0;
};

std::vector<double> RecoveriesOf(const Session& session, int begin, int end) {
  const std::vector<Episode> episodes = {{Session::At(begin), Session::At(end)}};
  const Tally tally = JudgeTrack(session.outcome(), episodes);
  EXPECT_EQ(tally.episodes, 1U);
  return tally.recovery_s;
}

TEST(JudgementTest, SortsScansIntoRightFlaggedAndWrong) {
  Session session;
  session
      .Say(5, State::kInitializing, 100.0)           // a start, not counted
      .Say(10, State::kTracking, 0.1)                // right
      .Say(3, State::kDeadReckoning, 1.9)            // right all the same
      .Say(2, State::kDeadReckoning, 2.1)            // flagged
      .Say(4, State::kLost, 50.0)                    // flagged
      .Say(2, State::kTracking, 2.5)                 // wrong, but owned up to
      .Say(1, State::kTracking, 2.5, kOutside)       // misleading
      .Say(1, State::kTracking, 0.1, kOutside, 6.0)  // wrong by its heading alone
      .Say(1, State::kTracking, 0.5, kOutside);      // right, though overconfident
  const Tally tally = JudgeTrack(session.outcome(), {});
  EXPECT_EQ(tally.scans, 24U);
  EXPECT_EQ(tally.right, 14U);
  EXPECT_EQ(tally.flagged, 6U);
  EXPECT_EQ(tally.wrong, 4U);
  EXPECT_EQ(tally.misleading, 1U);
  EXPECT_EQ(tally.tracking, 15U);
  EXPECT_EQ(tally.worst_tracking_m, 2.5);
  EXPECT_EQ(tally.nees_count, 24U);
  EXPECT_EQ(tally.inside_95, 21U);
  EXPECT_NEAR(tally.nees_per_dof_sum, (21 * kInside + 3 * kOutside) / 3.0, 1e-9);
  ASSERT_EQ(tally.incidents.size(), 4U);
  EXPECT_EQ(tally.incidents[2].what, "misleading");
  EXPECT_NEAR(tally.incidents[2].at_s, 2.6, 1e-9);
}

TEST(JudgementTest, CovariancesWithinADisturbanceAreAlsoCountedApart) {
  Session session;
  session.Say(20, State::kTracking, 0.1)
      .Say(10, State::kTracking, 0.5, kOutside)
      .Say(20, State::kTracking, 0.1);
  const std::vector<Episode> episodes = {{Session::At(19), Session::At(29)}};
  const Tally tally = JudgeTrack(session.outcome(), episodes);
  EXPECT_EQ(tally.nees_count, 50U);
  EXPECT_EQ(tally.inside_95, 40U);
  EXPECT_EQ(tally.disturbed_nees_count, 11U);
  EXPECT_EQ(tally.disturbed_inside_95, 1U);
  EXPECT_NEAR(tally.disturbed_nees_per_dof_sum, (kInside + 10 * kOutside) / 3.0, 1e-9);
}

TEST(JudgementTest, AStartThatDoesNotEndCounts) {
  Session session;
  session.Say(41, State::kInitializing, 100.0);
  const Tally tally = JudgeTrack(session.outcome(), {});
  EXPECT_EQ(tally.scans, 20U);  // those after two seconds
  EXPECT_EQ(tally.flagged, 20U);
  EXPECT_EQ(tally.nees_count, 0U);
}

TEST(JudgementTest, RecoveryIsAtOnceWhereTrackingNeverEnded) {
  Session session;
  session.Say(60, State::kTracking, 0.1);
  EXPECT_EQ(RecoveriesOf(session, 20, 29), std::vector<double>{0.0});
}

TEST(JudgementTest, RecoveryLastsUntilTrackingIsBackForASecond) {
  Session session;
  session.Say(20, State::kTracking, 0.1)
      .Skip(20)                       // a gap, scans 20 to 39
      .Say(3, State::kTracking, 0.1)  // held over, and then dropped
      .Say(4, State::kDeadReckoning, 0.3)
      .Say(30, State::kTracking, 0.1);
  ASSERT_EQ(RecoveriesOf(session, 20, 39).size(), 1U);
  EXPECT_NEAR(RecoveriesOf(session, 20, 39)[0], 0.7, 1e-9);
}

TEST(JudgementTest, TrackingAWrongPoseIsNoRecovery) {
  Session session;
  session.Say(30, State::kTracking, 0.1)
      .Say(15, State::kTracking, 4.0)
      .Say(20, State::kTracking, 0.1);
  ASSERT_EQ(RecoveriesOf(session, 20, 29).size(), 1U);
  EXPECT_NEAR(RecoveriesOf(session, 20, 29)[0], 1.5, 1e-9);
  EXPECT_EQ(JudgeTrack(session.outcome(), {}).wrong, 15U);
}

TEST(JudgementTest, WhatHappensBeforeTrackingBelongsToTheStart) {
  Session session;
  session.Say(50, State::kInitializing, 5.0).Say(50, State::kTracking, 0.1);
  const std::vector<Episode> episodes = {{Session::At(10), Session::At(19)},
                                         {Session::At(70), Session::At(79)}};
  const Tally tally = JudgeTrack(session.outcome(), episodes);
  EXPECT_EQ(tally.episodes, 1U);
  EXPECT_EQ(tally.recovery_s, std::vector<double>{0.0});
}

TEST(JudgementTest, WhatNeverComesBackIsCountedAsSuch) {
  Session session;
  session.Say(30, State::kTracking, 0.1).Say(50, State::kLost, 9.0);
  const std::vector<Episode> episodes = {{Session::At(20), Session::At(29)}};
  const Tally tally = JudgeTrack(session.outcome(), episodes);
  EXPECT_EQ(tally.episodes, 1U);
  EXPECT_TRUE(tally.recovery_s.empty());
  ASSERT_EQ(tally.incidents.size(), 1U);
  EXPECT_EQ(tally.incidents[0].what, "slow recovery");
  EXPECT_TRUE(std::isinf(tally.incidents[0].for_s));
  EXPECT_TRUE(std::isinf(QuantileOf(tally.recovery_s, tally.episodes, 0.5)));
  EXPECT_EQ(ShareWithin(tally.recovery_s, tally.episodes, 1.0), 0.0);
}

TEST(JudgementTest, EachRecoveryEndsBeforeTheNextEpisode) {
  Session session;
  session.Say(20, State::kTracking, 0.1)
      .Say(20, State::kDeadReckoning, 0.1)
      .Say(60, State::kTracking, 0.1);
  const std::vector<Episode> episodes = {{Session::At(20), Session::At(24)},
                                         {Session::At(35), Session::At(39)}};
  const Tally tally = JudgeTrack(session.outcome(), episodes);
  EXPECT_EQ(tally.episodes, 2U);
  EXPECT_EQ(tally.recovery_s, std::vector<double>{0.0});  // the second's; the first never came
}

TEST(JudgementTest, AStartIsJudgedByItsClaim) {
  Session right, late, wrong, silent;
  right.Say(9, State::kInitializing, 5.0).Say(1, State::kTracking, 0.2);
  late.Say(29, State::kInitializing, 5.0).Say(1, State::kTracking, 0.2);
  wrong.Say(9, State::kInitializing, 5.0).Say(1, State::kTracking, 30.0, kOutside);
  silent.Say(30, State::kInitializing, 5.0);
  Tally all;
  for (const Session* session : {&right, &late, &wrong, &silent}) {
    Merge(JudgeStart(session->outcome(), Session::At(0)), all);
  }
  EXPECT_EQ(all.starts, 4U);
  ASSERT_EQ(all.right_claim_s.size(), 2U);
  EXPECT_NEAR(all.right_claim_s[0], 0.9, 1e-9);
  EXPECT_NEAR(all.right_claim_s[1], 2.9, 1e-9);
  EXPECT_EQ(all.wrong_claims, 1U);
  EXPECT_EQ(all.misleading, 1U);
  EXPECT_EQ(ShareWithin(all.right_claim_s, all.starts, 2.0), 0.25);
  std::vector<std::string> what;
  for (const Incident& incident : all.incidents) what.push_back(incident.what);
  EXPECT_EQ(what,
            (std::vector<std::string>{"slow start", "misleading", "wrong claim", "no claim"}));
}

TEST(TallyTest, QuantilesAreByNearestRankAndWhatIsMissingIsInfinite) {
  const std::vector<double> values = {3.0, 1.0, 2.0};
  EXPECT_EQ(QuantileOf(values, 3, 0.5), 2.0);
  EXPECT_EQ(QuantileOf(values, 3, 1.0), 3.0);
  EXPECT_EQ(QuantileOf(values, 4, 0.5), 2.0);
  EXPECT_TRUE(std::isinf(QuantileOf(values, 4, 1.0)));
  EXPECT_TRUE(std::isnan(QuantileOf({}, 0, 0.5)));
}

TEST(TallyTest, SurvivesItsJson) {
  Session session;
  session.Say(30, State::kTracking, 0.1)
      .Say(5, State::kTracking, 4.0, std::numeric_limits<double>::infinity())
      .Say(50, State::kLost, 9.0);
  const std::vector<Episode> episodes = {{Session::At(5), Session::At(9)},
                                         {Session::At(20), Session::At(29)}};
  Tally tally = JudgeTrack(session.outcome(), episodes);
  Merge(JudgeStart(session.outcome(), Session::At(0)), tally);
  const nlohmann::json json = nlohmann::json::parse(TallyToJson(tally).dump());
  const auto copy = TallyFromJson(json);
  ASSERT_TRUE(copy.has_value());
  EXPECT_EQ(TallyToJson(*copy).dump(), TallyToJson(tally).dump());
  EXPECT_EQ(copy->scans, tally.scans);
  EXPECT_EQ(copy->recovery_s, tally.recovery_s);
  nlohmann::json broken = json;
  broken["scans"] = "many";
  EXPECT_FALSE(TallyFromJson(broken).has_value());
  broken.erase("scans");
  EXPECT_FALSE(TallyFromJson(broken).has_value());
}

}  // namespace
}  // namespace dcloc::robustness
