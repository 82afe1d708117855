#include "server/localization/stream_state.h"

#include <gtest/gtest.h>

#include <array>
#include <ostream>
#include <string>
#include <vector>

namespace dcloc::server {
namespace {

using Action = StreamAction;
using Event = StreamEvent;
using State = StreamState;

constexpr std::array kStreamStates = {
    State::kAdmitting, State::kOpening,          State::kStreaming,
    State::kDetaching, State::kDraining,         State::kFailing,
    State::kCancelled, State::kCancelledForGood, State::kFinished};
constexpr std::array kStreamEvents = {
    Event::kAdmitted, Event::kFirstRead, Event::kScanRead, Event::kClosed,    Event::kHalfClosed,
    Event::kOpened,   Event::kFailed,    Event::kEnded,    Event::kCancelled, Event::kSettled};

struct StreamArrow {
  const char* name;
  State from;
  Event event;
  State to;
  Action action;
};

void PrintTo(const StreamArrow& arrow, std::ostream* out) { *out << arrow.name; }

const std::vector<StreamArrow>& StreamArrows() {
  static const std::vector<StreamArrow> arrows = {
      {"ACallerThatMayLocalizeIsAdmitted", State::kAdmitting, Event::kAdmitted, State::kOpening,
       Action::kNone},
      {"ACallerThatMayNotIsRefused", State::kAdmitting, Event::kFailed, State::kFailing,
       Action::kTakeStatus},
      {"AServerThatTakesNoMoreEndsTheAdmission", State::kAdmitting, Event::kEnded, State::kDraining,
       Action::kTakeStatus},
      {"AnAdmissionIsCancelled", State::kAdmitting, Event::kCancelled, State::kCancelled,
       Action::kNone},
      {"TheFirstMessageOpensASession", State::kOpening, Event::kFirstRead, State::kOpening,
       Action::kOpenSession},
      {"AnOpenSessionStreams", State::kOpening, Event::kOpened, State::kStreaming,
       Action::kAttachSession},
      {"AClientThatSaysNothingIsDone", State::kOpening, Event::kClosed, State::kDraining,
       Action::kNone},
      {"ARefusedOpeningFails", State::kOpening, Event::kFailed, State::kFailing,
       Action::kTakeStatus},
      {"AServerThatTakesNoMoreEndsTheOpening", State::kOpening, Event::kEnded, State::kDraining,
       Action::kTakeStatus},
      {"AnOpeningIsCancelled", State::kOpening, Event::kCancelled, State::kCancelled,
       Action::kNone},

      {"AScanIsQueued", State::kStreaming, Event::kScanRead, State::kStreaming, Action::kQueueScan},
      {"AClosedSessionDrains", State::kStreaming, Event::kClosed, State::kDraining, Action::kNone},
      {"AHalfClosedResumableOneDetaches", State::kStreaming, Event::kHalfClosed, State::kDetaching,
       Action::kNone},
      {"ABadMessageOrATakeoverFailsTheStream", State::kStreaming, Event::kFailed, State::kFailing,
       Action::kTakeStatus},
      {"TheServerEndsTheSession", State::kStreaming, Event::kEnded, State::kDraining,
       Action::kTakeStatus},
      {"ABrokenConnectionKeepsTheSession", State::kStreaming, Event::kCancelled, State::kCancelled,
       Action::kNone},

      {"ATakeoverFailsADetachingStream", State::kDetaching, Event::kFailed, State::kFailing,
       Action::kTakeStatus},
      {"TheServerEndsADetachingSession", State::kDetaching, Event::kEnded, State::kDraining,
       Action::kTakeStatus},
      {"ADetachingStreamBreaks", State::kDetaching, Event::kCancelled, State::kCancelled,
       Action::kNone},
      {"ADetachingStreamFinishes", State::kDetaching, Event::kSettled, State::kFinished,
       Action::kFinish},

      {"AnOpeningUnderWayIsAttachedBeforeItsEnd", State::kDraining, Event::kOpened,
       State::kDraining, Action::kAttachSession},
      {"AReadUnderWayIsAnsweredBeforeTheEnd", State::kDraining, Event::kScanRead, State::kDraining,
       Action::kQueueScan},
      {"ABadMessageFailsADrainingStream", State::kDraining, Event::kFailed, State::kFailing,
       Action::kTakeStatus},
      {"ADrainingStreamBreaks", State::kDraining, Event::kCancelled, State::kCancelledForGood,
       Action::kNone},
      {"ADrainedStreamFinishes", State::kDraining, Event::kSettled, State::kFinished,
       Action::kFinish},

      {"TheLastFailureIsTold", State::kFailing, Event::kFailed, State::kFailing,
       Action::kTakeStatus},
      {"AFailingStreamBreaks", State::kFailing, Event::kCancelled, State::kCancelledForGood,
       Action::kNone},
      {"AFailedStreamFinishes", State::kFailing, Event::kSettled, State::kFinished,
       Action::kFinish},

      {"AnOpeningUnderWayIsAttachedThoughNobodyListens", State::kCancelled, Event::kOpened,
       State::kCancelled, Action::kAttachSession},
      {"ACloseThatStillArrivesEndsTheSession", State::kCancelled, Event::kClosed,
       State::kCancelledForGood, Action::kNone},
      {"ABadMessageEndsACancelledSession", State::kCancelled, Event::kFailed,
       State::kCancelledForGood, Action::kTakeStatus},
      {"TheServerEndsACancelledSession", State::kCancelled, Event::kEnded, State::kCancelledForGood,
       Action::kTakeStatus},
      {"ACancelledStreamFinishes", State::kCancelled, Event::kSettled, State::kFinished,
       Action::kFinish},

      {"AnOpeningUnderWayIsAttachedToBeLetGo", State::kCancelledForGood, Event::kOpened,
       State::kCancelledForGood, Action::kAttachSession},
      {"TheLastFailureIsTheReason", State::kCancelledForGood, Event::kFailed,
       State::kCancelledForGood, Action::kTakeStatus},
      {"ACancelledSessionsStreamFinishes", State::kCancelledForGood, Event::kSettled,
       State::kFinished, Action::kFinish},
  };
  return arrows;
}

class StreamArrowTest : public ::testing::TestWithParam<StreamArrow> {};

TEST_P(StreamArrowTest, LeadsThere) {
  const StreamTransition next = Next(GetParam().from, GetParam().event);
  EXPECT_EQ(next.state, GetParam().to);
  EXPECT_EQ(next.action, GetParam().action);
}

INSTANTIATE_TEST_SUITE_P(, StreamArrowTest, ::testing::ValuesIn(StreamArrows()),
                         [](const ::testing::TestParamInfo<StreamArrow>& arrow) {
                           return std::string(arrow.param.name);
                         });

bool IsStreamArrow(State from, Event event) {
  for (const StreamArrow& arrow : StreamArrows()) {
    if (arrow.from == from && arrow.event == event) return true;
  }
  return false;
}

TEST(StreamStateTest, NothingElseChangesAnything) {
  for (const State state : kStreamStates) {
    for (const Event event : kStreamEvents) {
      if (IsStreamArrow(state, event)) continue;
      const StreamTransition next = Next(state, event);
      EXPECT_EQ(next.state, state) << static_cast<int>(state) << " " << static_cast<int>(event);
      EXPECT_EQ(next.action, Action::kNone)
          << static_cast<int>(state) << " " << static_cast<int>(event);
    }
  }
}

TEST(StreamStateTest, WhoeverCanSettleFinishesAndNothingFollowsTheEnd) {
  for (const State state : kStreamStates) {
    const bool settles = RulesOf(state).must_write != MustWrite::kEverything;
    EXPECT_EQ(Next(state, Event::kSettled).action == Action::kFinish, settles)
        << static_cast<int>(state);
  }
  const StreamRules after = RulesOf(State::kFinished);
  EXPECT_FALSE(after.reads || after.writes || after.answers);
}

TEST(StreamStateTest, NothingIsWrittenToWhoDoesNotListen) {
  for (const State state : {State::kCancelled, State::kCancelledForGood}) {
    EXPECT_FALSE(RulesOf(state).writes);
    EXPECT_EQ(RulesOf(state).must_write, MustWrite::kNothing);
  }
}

TEST(StreamStateTest, OnlyOpenStreamsReadAndOnlyUnendedOnesKeepTheirSession) {
  for (const State state : kStreamStates) {
    EXPECT_EQ(RulesOf(state).reads, state == State::kOpening || state == State::kStreaming);
    EXPECT_EQ(RulesOf(state).keeps_session,
              state == State::kDetaching || state == State::kCancelled);
  }
}

TEST(StreamStateTest, AFailedStreamAnswersNoMore) {
  EXPECT_TRUE(RulesOf(State::kDraining).answers);
  EXPECT_EQ(RulesOf(State::kDraining).must_write, MustWrite::kWhatWasRead);
  EXPECT_FALSE(RulesOf(State::kFailing).answers);
  EXPECT_EQ(RulesOf(State::kFailing).must_write, MustWrite::kWhatIsMade);
}

}  // namespace
}  // namespace dcloc::server
