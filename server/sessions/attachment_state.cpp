#include "server/sessions/attachment_state.h"

#include <array>

#include "server/base/transition_table.h"

namespace dcloc::server {
namespace {

using State = AttachmentState;
using Event = AttachmentEvent;
using Action = AttachmentAction;

using Arrow = TransitionArrow<State, Event, Action>;

constexpr std::array kArrows = {
    Arrow{State::kAttached, Event::kAttach, State::kAttached, Action::kTakeStream},
    Arrow{State::kAttached, Event::kDetach, State::kDetached, Action::kDropStream},
    Arrow{State::kAttached, Event::kClose, State::kEnded, Action::kRelease},
    Arrow{State::kAttached, Event::kEnd, State::kEnding, Action::kTellStream},

    Arrow{State::kEnding, Event::kAttach, State::kEnding, Action::kRefuse},
    Arrow{State::kEnding, Event::kDetach, State::kAbandoned, Action::kDropStream},
    Arrow{State::kEnding, Event::kClose, State::kEnded, Action::kRelease},
    Arrow{State::kEnding, Event::kEnd, State::kEnding, Action::kTellStream},
    Arrow{State::kEnding, Event::kOverdue, State::kEnding, Action::kAbortStream},

    Arrow{State::kDetached, Event::kAttach, State::kAttached, Action::kTakeStream},
    Arrow{State::kDetached, Event::kEnd, State::kEnded, Action::kRelease},
    Arrow{State::kDetached, Event::kExpire, State::kEnded, Action::kRelease},
    Arrow{State::kDetached, Event::kEvict, State::kEnded, Action::kRelease},
    Arrow{State::kDetached, Event::kDrain, State::kEnded, Action::kRelease},

    Arrow{State::kAbandoned, Event::kAttach, State::kAbandoned, Action::kRefuse},
    Arrow{State::kAbandoned, Event::kEnd, State::kEnded, Action::kRelease},
    Arrow{State::kAbandoned, Event::kExpire, State::kEnded, Action::kRelease},
    Arrow{State::kAbandoned, Event::kEvict, State::kEnded, Action::kRelease},
    Arrow{State::kAbandoned, Event::kDrain, State::kEnded, Action::kRelease},
};

}  // namespace

AttachmentTransition Next(AttachmentState state, AttachmentEvent event) {
  return NextIn<AttachmentTransition>(kArrows, state, event);
}

}  // namespace dcloc::server
