#include "server/sessions/attachment_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <ostream>
#include <string>

// A namespace of its own: the states of streams have the same short names.
namespace dcloc::server::attachment_state_test {
namespace {

using State = AttachmentState;
using Event = AttachmentEvent;
using Action = AttachmentAction;

struct AttachmentArrow {
  const char* name;
  AttachmentState from;
  AttachmentEvent event;
  AttachmentState to;
  AttachmentAction action;
};

void PrintTo(const AttachmentArrow& arrow, std::ostream* out) { *out << arrow.name; }

class AttachmentArrowTest : public ::testing::TestWithParam<AttachmentArrow> {};

TEST_P(AttachmentArrowTest, LeadsThere) {
  const AttachmentTransition next = Next(GetParam().from, GetParam().event);
  EXPECT_EQ(next.state, GetParam().to);
  EXPECT_EQ(next.action, GetParam().action);
}

INSTANTIATE_TEST_SUITE_P(
    , AttachmentArrowTest,
    ::testing::Values(AttachmentArrow{"AnotherStreamTakesItOver", State::kAttached, Event::kAttach,
                                      State::kAttached, Action::kTakeStream},
                      AttachmentArrow{"ItsStreamLeavesIt", State::kAttached, Event::kDetach,
                                      State::kDetached, Action::kDropStream},
                      AttachmentArrow{"ItsStreamClosesIt", State::kAttached, Event::kClose,
                                      State::kEnded, Action::kRelease},
                      AttachmentArrow{"ItsStreamIsToldToEnd", State::kAttached, Event::kEnd,
                                      State::kEnding, Action::kTellStream},
                      AttachmentArrow{"OneThatEndsIsNotResumed", State::kEnding, Event::kAttach,
                                      State::kEnding, Action::kRefuse},
                      AttachmentArrow{"OneThatEndsLosesItsStream", State::kEnding, Event::kDetach,
                                      State::kAbandoned, Action::kDropStream},
                      AttachmentArrow{"OneThatEndsIsClosed", State::kEnding, Event::kClose,
                                      State::kEnded, Action::kRelease},
                      AttachmentArrow{"OneThatEndsIsToldAgain", State::kEnding, Event::kEnd,
                                      State::kEnding, Action::kTellStream},
                      AttachmentArrow{"OneThatDoesNotEndIsCutOff", State::kEnding, Event::kOverdue,
                                      State::kEnding, Action::kAbortStream},
                      AttachmentArrow{"ItsClientResumesIt", State::kDetached, Event::kAttach,
                                      State::kAttached, Action::kTakeStream},
                      AttachmentArrow{"ADetachedOneEndsAtOnce", State::kDetached, Event::kEnd,
                                      State::kEnded, Action::kRelease},
                      AttachmentArrow{"ADetachedOneExpires", State::kDetached, Event::kExpire,
                                      State::kEnded, Action::kRelease},
                      AttachmentArrow{"ADetachedOneMakesRoom", State::kDetached, Event::kEvict,
                                      State::kEnded, Action::kRelease},
                      AttachmentArrow{"ADetachedOneGoesWithTheServer", State::kDetached,
                                      Event::kDrain, State::kEnded, Action::kRelease},
                      AttachmentArrow{"AnAbandonedOneIsNotResumed", State::kAbandoned,
                                      Event::kAttach, State::kAbandoned, Action::kRefuse},
                      AttachmentArrow{"AnAbandonedOneEndsAtOnce", State::kAbandoned, Event::kEnd,
                                      State::kEnded, Action::kRelease},
                      AttachmentArrow{"AnAbandonedOneExpires", State::kAbandoned, Event::kExpire,
                                      State::kEnded, Action::kRelease},
                      AttachmentArrow{"AnAbandonedOneMakesRoom", State::kAbandoned, Event::kEvict,
                                      State::kEnded, Action::kRelease},
                      AttachmentArrow{"AnAbandonedOneGoesWithTheServer", State::kAbandoned,
                                      Event::kDrain, State::kEnded, Action::kRelease}),
    [](const ::testing::TestParamInfo<AttachmentArrow>& arrow) {
      return std::string(arrow.param.name);
    });

constexpr std::array kStates = {State::kAttached, State::kEnding, State::kDetached,
                                State::kAbandoned, State::kEnded};
constexpr std::array kEvents = {Event::kAttach,  Event::kDetach, Event::kClose, Event::kEnd,
                                Event::kOverdue, Event::kExpire, Event::kEvict, Event::kDrain};

int ArrowCount(State state) {
  return static_cast<int>(std::ranges::count_if(
      kEvents, [&](Event event) { return Next(state, event).action != Action::kNone; }));
}

TEST(AttachmentStateTest, ThereAreNoOtherArrows) {
  EXPECT_EQ(ArrowCount(State::kAttached), 4);
  EXPECT_EQ(ArrowCount(State::kEnding), 5);
  EXPECT_EQ(ArrowCount(State::kDetached), 5);
  EXPECT_EQ(ArrowCount(State::kAbandoned), 5);
  EXPECT_EQ(ArrowCount(State::kEnded), 0) << "what has ended is not changed any more";
}

TEST(AttachmentStateTest, WhatIsReleasedHasEndedAndNothingElseHas) {
  for (const State state : kStates) {
    for (const Event event : kEvents) {
      const AttachmentTransition next = Next(state, event);
      if (state == State::kEnded) continue;
      EXPECT_EQ(next.action == Action::kRelease, next.state == State::kEnded);
    }
  }
}

TEST(AttachmentStateTest, AnEventWithoutAnArrowChangesNothing) {
  for (const State state : kStates) {
    for (const Event event : kEvents) {
      const AttachmentTransition next = Next(state, event);
      EXPECT_TRUE(next.action != Action::kNone || next.state == state);
    }
  }
}

TEST(AttachmentStateTest, WithoutAStreamThereIsNoneToLose) {
  for (const AttachmentState state : {AttachmentState::kDetached, AttachmentState::kAbandoned}) {
    EXPECT_TRUE(IsDetached(state));
    EXPECT_EQ(Next(state, AttachmentEvent::kDetach).state, state);
    EXPECT_EQ(Next(state, AttachmentEvent::kDetach).action, AttachmentAction::kNone);
  }
  EXPECT_FALSE(IsDetached(AttachmentState::kAttached) || IsDetached(AttachmentState::kEnding));
}

}  // namespace
}  // namespace dcloc::server::attachment_state_test
