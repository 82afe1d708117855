#include "server/sessions/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <latch>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/sessions/session_test_parts.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class SessionTest : public SessionParts {
 protected:
  /// Where its next task will run.
  Lane LaneOf(Session& session) {
    const auto busy = std::make_shared<std::latch>(2);
    const auto release = std::make_shared<std::latch>(1);
    for (const Lane lane : {Lane::kQuick, Lane::kLengthy}) {
      pool_.Post(
          [busy, release] {
            busy->count_down();
            release->wait();
          },
          lane);
    }
    busy->wait();
    std::promise<void> done;
    session.strand().Post([&done] { done.set_value(); });
    const Lane lane = pool_.queued_count(Lane::kLengthy) > 0 ? Lane::kLengthy : Lane::kQuick;
    release->count_down();
    done.get_future().wait();
    return lane;
  }
};

class Watcher final : public AnswerSubscriber {
 public:
  void OnAnswer(const ScanAnswer& answer, const v1::Scan* scan) override {
    numbers.push_back(answer.sequence_number);
    scan_numbers.push_back(scan == nullptr ? kNoScan : scan->sequence_number());
  }
  void OnFixAnswer(const FixAnswer& answer) override { fixes.push_back(answer.stamp_ns); }
  void OnEnd() override { ended = true; }

  static constexpr std::int64_t kNoScan = -1;
  std::vector<std::int64_t> numbers;
  std::vector<std::int64_t> scan_numbers;
  std::vector<std::int64_t> fixes;
  bool ended = false;
};

class Recorder final : public RecordingSubscriber {
 public:
  void OnOpened(const RecordingStart& start) override {
    vehicle_id = start.open.vehicle_id();
    resume_token = start.session.resume_token;
  }
  void OnScan(const v1::Scan& scan, const ScanAnswer& answer) override {
    EXPECT_EQ(scan.sequence_number(), answer.sequence_number);
    target_counts.push_back(scan.range_m_size());
  }
  bool TakesFixes() const override { return takes_fixes; }
  void OnFix(const v1::PositionFix& fix, const FixAnswer& answer) override {
    EXPECT_EQ(fix.stamp_ns(), answer.stamp_ns);
    target_counts.push_back(kFix);
  }
  void OnEnd(const absl::Status& /*status*/) override { ended = true; }

  std::string vehicle_id;
  std::string resume_token = "none was given";
  static constexpr int kFix = -1;
  bool takes_fixes = true;
  std::vector<int> target_counts;
  bool ended = false;
};

TEST_F(SessionTest, AnswersWithWhatTheLocalizerSays) {
  const auto session = MakeSession();
  script_.state = LocalizationState::kDeadReckoning;
  const ScanAnswer answer = Answer(*session, ScanMessage(7));
  ASSERT_TRUE(answer.result.ok()) << answer.result.status();
  EXPECT_EQ(answer.sequence_number, 7);
  EXPECT_EQ(answer.result->map_version, 1);
  EXPECT_EQ(answer.result->localization.state, LocalizationState::kDeadReckoning);
  EXPECT_FALSE(answer.from_memory);
  const ScanTimings& timings = answer.result->timings;
  EXPECT_GT(timings.registration.count(), 0);
  EXPECT_EQ(timings.posegraph.count(), 0) << "it did not run";
  EXPECT_GE(timings.total, timings.queue + timings.conversion + timings.registration);
  EXPECT_EQ(session->info()->counts.answered, 1);
  EXPECT_EQ(totals_.answered, 1);
  EXPECT_EQ(session->info()->last_sequence_number, 7);
  EXPECT_EQ(session->Describe(true).last_sequence_number, 7);
}

TEST_F(SessionTest, AScanThatComesAgainIsNotLocalizedAgain) {
  const auto session = MakeSession();
  const ScanAnswer first = Answer(*session, ScanMessage(1));
  v1::Scan number_alone;
  number_alone.set_sequence_number(1);
  const ScanAnswer again = Answer(*session, number_alone);
  ASSERT_TRUE(again.result.ok());
  EXPECT_TRUE(again.from_memory);
  EXPECT_EQ(again.result->timings.total, first.result->timings.total) << "as it was";
  EXPECT_EQ(script_.scans.size(), 1U);
  EXPECT_EQ(session->info()->counts.repeated, 1);
}

TEST_F(SessionTest, ARejectionNamesTheFieldAndChangesNothing) {
  const auto session = MakeSession();
  ASSERT_TRUE(Answer(*session, ScanMessage(1)).result.ok());
  v1::Scan broken = ScanMessage(2);
  broken.set_radar_id("nobody");
  const ScanAnswer answer = Answer(*session, broken);
  EXPECT_EQ(answer.result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(answer.result.status().message()), HasSubstr("scan.radar_id"));
  EXPECT_EQ(session->info()->counts.rejected, 1);
  EXPECT_EQ(session->Describe(false).last_sequence_number, 1);
  script_.status = absl::InvalidArgumentError("stamp_ns is early");
  EXPECT_EQ(Answer(*session, ScanMessage(3)).result.status().message(), "scan: stamp_ns is early");
  EXPECT_EQ(session->info()->missing_scan_count, 0);
}

TEST_F(SessionTest, ALateScanPushesNoAnswerOut) {
  const auto session = MakeSession();
  for (int i = 10; i < 14; ++i) ASSERT_TRUE(Answer(*session, ScanMessage(i)).result.ok());
  EXPECT_EQ(Answer(*session, ScanMessage(5)).result.status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_TRUE(Answer(*session, ScanMessage(10)).from_memory);
}

TEST_F(SessionTest, ADroppedScanIsAnsweredAndCounted) {
  const auto session = MakeSession();
  ASSERT_TRUE(Answer(*session, ScanMessage(1)).result.ok());
  const ScanAnswer dropped = AnswerDropped(*session, 3);
  EXPECT_EQ(dropped.result.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(dropped.dropped_scan_count, 1);
  EXPECT_EQ(session->info()->missing_scan_count, 1) << "2 never came";
  EXPECT_EQ(Answer(*session, ScanMessage(4)).dropped_scan_count, 1);
  EXPECT_TRUE(Answer(*session, ScanMessage(3)).from_memory);
}

TEST_F(SessionTest, WatchersSeeNewAnswersAloneAndTheEnd) {
  auto session = MakeSession();
  const auto watcher = std::make_shared<Watcher>();
  ASSERT_TRUE(session->info()->feed.Subscribe(watcher).ok());
  Answer(*session, ScanMessage(1));
  Answer(*session, ScanMessage(1));
  AnswerDropped(*session, 2);
  EXPECT_EQ(watcher->numbers, (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(watcher->scan_numbers, (std::vector<std::int64_t>{1, Watcher::kNoScan}));
  EXPECT_FALSE(watcher->ended);
  session.reset();
  EXPECT_TRUE(watcher->ended);
}

TEST_F(SessionTest, ARecordingHasTheOpeningWithoutItsSecretTheScansAndTheEnd) {
  auto session = MakeSession();
  const auto recorder = std::make_shared<Recorder>();
  session->Record(recorder, OpenMessage());
  EXPECT_TRUE(session->info()->recorded);
  EXPECT_EQ(recorder->vehicle_id, "car-1");
  EXPECT_EQ(recorder->resume_token, "");
  Answer(*session, ScanMessage(1, 20));
  Answer(*session, ScanMessage(1, 20));  // from memory: not recorded
  AnswerDropped(*session, 2);
  EXPECT_EQ(recorder->target_counts, (std::vector<int>{20, 0}));
  session.reset();
  EXPECT_TRUE(recorder->ended);
}

TEST_F(SessionTest, AFixIsNoScan) {
  const auto session = MakeSession();
  Answer(*session, ScanMessage(1));
  const FixAnswer answer = TakeFix(*session, FixMessage(2));
  EXPECT_EQ(answer.use.value(), FixUse::kFused);
  EXPECT_EQ(answer.stamp_ns, FixMessage(2).stamp_ns());
  ASSERT_EQ(script_.fixes.size(), 1U);
  EXPECT_EQ(script_.fixes[0].stamp.time_since_epoch().count(), FixMessage(2).stamp_ns());
  const SessionInfo& info = *session->info();
  EXPECT_EQ(info.position_fix_count, 1);
  EXPECT_EQ(info.counts.answered, 1);
  EXPECT_EQ(info.last_sequence_number, 1);
  EXPECT_EQ(Answer(*session, ScanMessage(2)).result.ok(), true);
  EXPECT_EQ(info.missing_scan_count, 0);
}

TEST_F(SessionTest, ABadFixNamesTheFieldAndReachesNoLocalizer) {
  const auto session = MakeSession();
  v1::PositionFix fix = FixMessage(1);
  fix.mutable_map_pose()->clear_covariance();
  const FixAnswer answer = TakeFix(*session, fix);
  EXPECT_EQ(answer.use.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(answer.use.status().message()), HasSubstr("position_fix.map_pose"));
  EXPECT_TRUE(script_.fixes.empty());
  script_.fix_use = absl::InvalidArgumentError("too flat");
  EXPECT_EQ(TakeFix(*session, FixMessage(1)).use.status().message(), "position_fix: too flat");
}

TEST_F(SessionTest, FixesBeyondTheRateOfScansAreNotLookedAt) {
  limits_.max_scan_rate_hz_per_principal = 3;
  const auto session = MakeSession();
  int used = 0;
  for (int i = 0; i < 1000; ++i) used += TakeFix(*session, FixMessage(i)).use.ok() ? 1 : 0;
  EXPECT_LE(used, 5);
  EXPECT_EQ(script_.fixes.size(), static_cast<std::size_t>(used));
  EXPECT_EQ(session->info()->position_fix_count, 1000);
  EXPECT_TRUE(Answer(*session, ScanMessage(1)).result.ok()) << "they take nothing from scans";
}

TEST_F(SessionTest, ASearchThatAFixBeginsIsOnTheLaneOfSearches) {
  const auto session = MakeSession();
  script_.state = LocalizationState::kTracking;
  Answer(*session, ScanMessage(1));
  ASSERT_EQ(LaneOf(*session), Lane::kQuick);
  script_.has_pose = false;
  TakeFix(*session, FixMessage(1));
  EXPECT_EQ(LaneOf(*session), Lane::kLengthy);
}

TEST_F(SessionTest, WhoHasNotFoundItsPlaceOrLostItIsOnTheLaneOfSearches) {
  const auto session = MakeSession();
  EXPECT_EQ(LaneOf(*session), Lane::kLengthy);
  std::int64_t number = 0;
  for (const auto& [state, lane] : {std::pair{LocalizationState::kInitializing, Lane::kLengthy},
                                    std::pair{LocalizationState::kTracking, Lane::kQuick},
                                    std::pair{LocalizationState::kDeadReckoning, Lane::kQuick},
                                    std::pair{LocalizationState::kLost, Lane::kLengthy},
                                    std::pair{LocalizationState::kTracking, Lane::kQuick}}) {
    script_.state = state;
    Answer(*session, ScanMessage(++number));
    EXPECT_EQ(LaneOf(*session), lane) << static_cast<int>(state);
  }
}

TEST_F(SessionTest, WhoSendsLargeScansNowAndThenIsOnThatLaneToo) {
  const auto session = MakeSession();
  script_.state = LocalizationState::kTracking;
  std::int64_t number = 0;
  const auto lane_after = [&](int target_count) {
    Answer(*session, ScanMessage(++number, target_count));
    return LaneOf(*session);
  };
  EXPECT_EQ(lane_after(4'000), Lane::kQuick);
  EXPECT_EQ(lane_after(8'000), Lane::kLengthy);
  for (int i = 0; i < 30; ++i) EXPECT_EQ(lane_after(100), Lane::kLengthy) << i;
  for (int i = 0; i < 10; ++i) lane_after(100);
  EXPECT_EQ(lane_after(100), Lane::kQuick);
}

TEST_F(SessionTest, WatchersAndRecordersGetFixesInTheirPlace) {
  const auto session = MakeSession();
  const auto watcher = std::make_shared<Watcher>();
  const auto recorder = std::make_shared<Recorder>();
  ASSERT_TRUE(session->info()->feed.Subscribe(watcher).ok());
  session->Record(recorder, OpenMessage());
  Answer(*session, ScanMessage(1, 20));
  TakeFix(*session, FixMessage(2));
  Answer(*session, ScanMessage(2, 30));
  EXPECT_EQ(watcher->fixes, (std::vector<std::int64_t>{FixMessage(2).stamp_ns()}));
  EXPECT_EQ(recorder->target_counts, (std::vector<int>{20, Recorder::kFix, 30}));
}

TEST_F(SessionTest, AProposalIsAFixAtTheLastScan) {
  const auto session = MakeSession();
  v1::PositionFix pose = FixMessage(0);
  pose.clear_stamp_ns();
  EXPECT_EQ(session->ProposePose(pose).status().code(), absl::StatusCode::kFailedPrecondition)
      << "no scan has told the vehicle's clock";
  Answer(*session, ScanMessage(1));
  EXPECT_EQ(session->ProposePose(pose)->stamp_ns, ScanMessage(1).stamp_ns());
  EXPECT_EQ(session->ProposePose(FixMessage(0))->stamp_ns, FixMessage(0).stamp_ns());
  EXPECT_EQ(script_.fixes.size(), 2U);
}

TEST_F(SessionTest, AProposalEndsNoRecording) {
  const auto session = MakeSession();
  const auto recorder = std::make_shared<Recorder>();
  recorder->takes_fixes = false;
  session->Record(recorder, OpenMessage());
  Answer(*session, ScanMessage(1, 20));
  EXPECT_EQ(session->ProposePose(FixMessage(1)).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(script_.fixes.empty());
  EXPECT_EQ(recorder->target_counts, (std::vector<int>{20}));
}

TEST_F(SessionTest, TheHealthOfTheLastAnswerIsListed) {
  const auto session = MakeSession();
  EXPECT_EQ(session->info()->health.Get().rig, nullptr);
  script_.health.radars.resize(1);
  script_.health.radars[0].fault = SourceFault::kMount;
  script_.resets.count = 2;
  Answer(*session, ScanMessage(1));
  const LastHealth::Value last = session->info()->health.Get();
  EXPECT_EQ(last.health, script_.health);
  EXPECT_EQ(last.rig->radars[0].id, "front");
  EXPECT_EQ(session->info()->pose_reset_count, 2);
}

TEST_F(SessionTest, ResetsGoOnCountingAfterAMove) {
  const auto session = MakeSession();
  script_.resets.count = 2;
  script_.resets.T_before_after.translation_m.x() = 7.0;
  Answer(*session, ScanMessage(1));
  ASSERT_TRUE(session->Move(Map(2)).ok());
  script_.resets = {};
  const ScanAnswer answer = Answer(*session, ScanMessage(2));
  const PoseResets& resets = answer.result->localization.resets;
  EXPECT_EQ(resets.count, 2);
  EXPECT_EQ(resets.T_before_after.translation_m.x(), 7.0);
  script_.resets.count = 1;
  EXPECT_EQ(Answer(*session, ScanMessage(3)).result->localization.resets.count, 3);
}

TEST_F(SessionTest, MovesWithTheLastPoseAsPriorAtTheLastScan) {
  const auto session = MakeSession();
  Answer(*session, ScanMessage(1));
  Answer(*session, ScanMessage(2));
  ASSERT_TRUE(session->Move(Map(2)).ok());
  ASSERT_EQ(script_.created_with.size(), 2U);
  EXPECT_FALSE(script_.created_with[0].has_value());
  ASSERT_TRUE(script_.created_with[1].has_value());
  EXPECT_EQ(script_.created_with[1]->T_map_vehicle.translation_m.x(), 1.0);
  ASSERT_EQ(script_.scans.size(), 3U);
  EXPECT_EQ(script_.scans[2].stamp, script_.scans[1].stamp);
  EXPECT_TRUE(script_.scans[2].range_m.empty()) << "its motion is known without its targets";
  EXPECT_EQ(session->info()->map_version, 2);
  EXPECT_EQ(Answer(*session, ScanMessage(3)).result->map_version, 2);
}

TEST_F(SessionTest, WithoutAnyConfirmedPoseItMovesWithoutAPrior) {
  const auto session = MakeSession();
  script_.state = LocalizationState::kInitializing;
  Answer(*session, ScanMessage(1));
  ASSERT_TRUE(session->Move(Map(2)).ok());
  EXPECT_FALSE(script_.created_with[1].has_value());
}

TEST_F(SessionTest, StaysWhereItCannotMove) {
  const auto session = MakeSession();
  create_status_ = absl::InvalidArgumentError("no");
  EXPECT_EQ(session->Move(Map(2)), create_status_);
  EXPECT_EQ(session->info()->map_version, 1);
  EXPECT_EQ(Answer(*session, ScanMessage(1)).result->map_version, 1);
}

TEST_F(SessionTest, OnlyAResumableOneNamesItsTimeout) {
  const auto session = MakeSession();
  EXPECT_EQ(session->Describe(false).detached_timeout, std::chrono::minutes(1));
  session->info()->description.resume_token.clear();
  EXPECT_EQ(session->Describe(false).detached_timeout.count(), 0);
  EXPECT_FALSE(session->Describe(false).last_sequence_number.has_value());
  EXPECT_EQ(session->Describe(false).answer_history_count, 4);
}

}  // namespace
}  // namespace dcloc::server
