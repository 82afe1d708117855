#include "server/sessions/attachment_state.h"

#include <array>

namespace dcloc::server {
namespace {

using State = AttachmentState;
using Event = AttachmentEvent;
using Action = AttachmentAction;

struct AttachmentArrow {
  State from;
  Event event;
  State to;
  Action action;
};

constexpr std::array kAttachmentArrows = {
    AttachmentArrow{State::kAttached, Event::kAttach, State::kAttached, Action::kTakeStream},
    AttachmentArrow{State::kAttached, Event::kDetach, State::kDetached, Action::kDropStream},
    AttachmentArrow{State::kAttached, Event::kClose, State::kEnded, Action::kRelease},
    AttachmentArrow{State::kAttached, Event::kEnd, State::kEnding, Action::kTellStream},

    AttachmentArrow{State::kEnding, Event::kAttach, State::kEnding, Action::kRefuse},
    AttachmentArrow{State::kEnding, Event::kDetach, State::kAbandoned, Action::kDropStream},
    AttachmentArrow{State::kEnding, Event::kClose, State::kEnded, Action::kRelease},
    AttachmentArrow{State::kEnding, Event::kEnd, State::kEnding, Action::kTellStream},
    AttachmentArrow{State::kEnding, Event::kOverdue, State::kEnding, Action::kAbortStream},

    AttachmentArrow{State::kDetached, Event::kAttach, State::kAttached, Action::kTakeStream},
    AttachmentArrow{State::kDetached, Event::kEnd, State::kEnded, Action::kRelease},
    AttachmentArrow{State::kDetached, Event::kExpire, State::kEnded, Action::kRelease},
    AttachmentArrow{State::kDetached, Event::kEvict, State::kEnded, Action::kRelease},
    AttachmentArrow{State::kDetached, Event::kDrain, State::kEnded, Action::kRelease},

    AttachmentArrow{State::kAbandoned, Event::kAttach, State::kAbandoned, Action::kRefuse},
    AttachmentArrow{State::kAbandoned, Event::kEnd, State::kEnded, Action::kRelease},
    AttachmentArrow{State::kAbandoned, Event::kExpire, State::kEnded, Action::kRelease},
    AttachmentArrow{State::kAbandoned, Event::kEvict, State::kEnded, Action::kRelease},
    AttachmentArrow{State::kAbandoned, Event::kDrain, State::kEnded, Action::kRelease},
};

}  // namespace

AttachmentTransition Next(AttachmentState state, AttachmentEvent event) {
  for (const AttachmentArrow& arrow : kAttachmentArrows) {
    if (arrow.from == state && arrow.event == event) return {arrow.to, arrow.action};
  }
  return {state, AttachmentAction::kNone};
}

}  // namespace dcloc::server
