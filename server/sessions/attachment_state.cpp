#include "server/sessions/attachment_state.h"

#include <array>

namespace dcloc::server {
namespace {

struct AttachmentArrow {
  AttachmentState from;
  AttachmentEvent event;
  AttachmentState to;
  AttachmentAction action;
};

constexpr std::array kAttachmentArrows = {
    AttachmentArrow{AttachmentState::kAttached, AttachmentEvent::kAttach,
                    AttachmentState::kAttached, AttachmentAction::kTakeStream},
    AttachmentArrow{AttachmentState::kAttached, AttachmentEvent::kDetach,
                    AttachmentState::kDetached, AttachmentAction::kDropStream},
    AttachmentArrow{AttachmentState::kAttached, AttachmentEvent::kEnd, AttachmentState::kEnding,
                    AttachmentAction::kTellStream},

    AttachmentArrow{AttachmentState::kEnding, AttachmentEvent::kAttach, AttachmentState::kEnding,
                    AttachmentAction::kRefuse},
    AttachmentArrow{AttachmentState::kEnding, AttachmentEvent::kDetach, AttachmentState::kAbandoned,
                    AttachmentAction::kDropStream},
    AttachmentArrow{AttachmentState::kEnding, AttachmentEvent::kEnd, AttachmentState::kEnding,
                    AttachmentAction::kTellStream},

    AttachmentArrow{AttachmentState::kDetached, AttachmentEvent::kAttach,
                    AttachmentState::kAttached, AttachmentAction::kTakeStream},
    AttachmentArrow{AttachmentState::kDetached, AttachmentEvent::kEnd, AttachmentState::kDetached,
                    AttachmentAction::kRelease},

    AttachmentArrow{AttachmentState::kAbandoned, AttachmentEvent::kAttach,
                    AttachmentState::kAbandoned, AttachmentAction::kRefuse},
    AttachmentArrow{AttachmentState::kAbandoned, AttachmentEvent::kEnd, AttachmentState::kAbandoned,
                    AttachmentAction::kRelease},
};

}  // namespace

AttachmentTransition Next(AttachmentState state, AttachmentEvent event) {
  for (const AttachmentArrow& arrow : kAttachmentArrows) {
    if (arrow.from == state && arrow.event == event) return {arrow.to, arrow.action};
  }
  return {state, AttachmentAction::kNone};
}

}  // namespace dcloc::server
