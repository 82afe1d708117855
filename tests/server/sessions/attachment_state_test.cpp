#include "server/sessions/attachment_state.h"

#include <gtest/gtest.h>

#include <ostream>
#include <string>

namespace dcloc::server {
namespace {

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
    ::testing::Values(
        AttachmentArrow{"AnotherStreamTakesItOver", AttachmentState::kAttached,
                        AttachmentEvent::kAttach, AttachmentState::kAttached,
                        AttachmentAction::kTakeStream},
        AttachmentArrow{"ItsStreamLeavesIt", AttachmentState::kAttached, AttachmentEvent::kDetach,
                        AttachmentState::kDetached, AttachmentAction::kDropStream},
        AttachmentArrow{"ItsStreamIsToldToEnd", AttachmentState::kAttached, AttachmentEvent::kEnd,
                        AttachmentState::kEnding, AttachmentAction::kTellStream},
        AttachmentArrow{"OneThatEndsIsNotResumed", AttachmentState::kEnding,
                        AttachmentEvent::kAttach, AttachmentState::kEnding,
                        AttachmentAction::kRefuse},
        AttachmentArrow{"OneThatEndsLosesItsStream", AttachmentState::kEnding,
                        AttachmentEvent::kDetach, AttachmentState::kAbandoned,
                        AttachmentAction::kDropStream},
        AttachmentArrow{"OneThatEndsIsToldAgain", AttachmentState::kEnding, AttachmentEvent::kEnd,
                        AttachmentState::kEnding, AttachmentAction::kTellStream},
        AttachmentArrow{"ItsClientResumesIt", AttachmentState::kDetached, AttachmentEvent::kAttach,
                        AttachmentState::kAttached, AttachmentAction::kTakeStream},
        AttachmentArrow{"ADetachedOneEndsAtOnce", AttachmentState::kDetached, AttachmentEvent::kEnd,
                        AttachmentState::kDetached, AttachmentAction::kRelease},
        AttachmentArrow{"AnAbandonedOneIsNotResumed", AttachmentState::kAbandoned,
                        AttachmentEvent::kAttach, AttachmentState::kAbandoned,
                        AttachmentAction::kRefuse},
        AttachmentArrow{"AnAbandonedOneEndsAtOnce", AttachmentState::kAbandoned,
                        AttachmentEvent::kEnd, AttachmentState::kAbandoned,
                        AttachmentAction::kRelease}),
    [](const ::testing::TestParamInfo<AttachmentArrow>& arrow) {
      return std::string(arrow.param.name);
    });

TEST(AttachmentStateTest, WithoutAStreamThereIsNoneToLose) {
  for (const AttachmentState state : {AttachmentState::kDetached, AttachmentState::kAbandoned}) {
    EXPECT_TRUE(IsDetached(state));
    EXPECT_EQ(Next(state, AttachmentEvent::kDetach).state, state);
    EXPECT_EQ(Next(state, AttachmentEvent::kDetach).action, AttachmentAction::kNone);
  }
  EXPECT_FALSE(IsDetached(AttachmentState::kAttached) || IsDetached(AttachmentState::kEnding));
}

}  // namespace
}  // namespace dcloc::server
