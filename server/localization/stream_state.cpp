#include "server/localization/stream_state.h"

#include <array>

#include "server/base/transition_table.h"

namespace dcloc::server {
namespace {

using Action = StreamAction;
using Event = StreamEvent;
using State = StreamState;

using Arrow = TransitionArrow<State, Event, Action>;

constexpr std::array kArrows = {
    Arrow{State::kAdmitting, Event::kAdmitted, State::kOpening, Action::kNone},
    Arrow{State::kAdmitting, Event::kFailed, State::kFailing, Action::kTakeStatus},
    Arrow{State::kAdmitting, Event::kEnded, State::kDraining, Action::kTakeStatus},
    Arrow{State::kAdmitting, Event::kCancelled, State::kCancelled, Action::kNone},

    Arrow{State::kOpening, Event::kFirstRead, State::kOpening, Action::kOpenSession},
    Arrow{State::kOpening, Event::kOpened, State::kStreaming, Action::kAttachSession},
    Arrow{State::kOpening, Event::kClosed, State::kDraining, Action::kNone},
    Arrow{State::kOpening, Event::kFailed, State::kFailing, Action::kTakeStatus},
    Arrow{State::kOpening, Event::kEnded, State::kDraining, Action::kTakeStatus},
    Arrow{State::kOpening, Event::kCancelled, State::kCancelled, Action::kNone},

    Arrow{State::kStreaming, Event::kScanRead, State::kStreaming, Action::kQueueScan},
    Arrow{State::kStreaming, Event::kClosed, State::kDraining, Action::kNone},
    Arrow{State::kStreaming, Event::kHalfClosed, State::kDetaching, Action::kNone},
    Arrow{State::kStreaming, Event::kFailed, State::kFailing, Action::kTakeStatus},
    Arrow{State::kStreaming, Event::kEnded, State::kDraining, Action::kTakeStatus},
    Arrow{State::kStreaming, Event::kCancelled, State::kCancelled, Action::kNone},

    Arrow{State::kDetaching, Event::kFailed, State::kFailing, Action::kTakeStatus},
    Arrow{State::kDetaching, Event::kEnded, State::kDraining, Action::kTakeStatus},
    Arrow{State::kDetaching, Event::kCancelled, State::kCancelled, Action::kNone},
    Arrow{State::kDetaching, Event::kSettled, State::kFinished, Action::kFinish},

    // What was under way when it was ended still counts: an opening, and a read.
    Arrow{State::kDraining, Event::kOpened, State::kDraining, Action::kAttachSession},
    Arrow{State::kDraining, Event::kScanRead, State::kDraining, Action::kQueueScan},
    Arrow{State::kDraining, Event::kFailed, State::kFailing, Action::kTakeStatus},
    Arrow{State::kDraining, Event::kCancelled, State::kCancelledForGood, Action::kNone},
    Arrow{State::kDraining, Event::kSettled, State::kFinished, Action::kFinish},

    Arrow{State::kFailing, Event::kFailed, State::kFailing, Action::kTakeStatus},
    Arrow{State::kFailing, Event::kCancelled, State::kCancelledForGood, Action::kNone},
    Arrow{State::kFailing, Event::kSettled, State::kFinished, Action::kFinish},

    Arrow{State::kCancelled, Event::kOpened, State::kCancelled, Action::kAttachSession},
    Arrow{State::kCancelled, Event::kClosed, State::kCancelledForGood, Action::kNone},
    Arrow{State::kCancelled, Event::kFailed, State::kCancelledForGood, Action::kTakeStatus},
    Arrow{State::kCancelled, Event::kEnded, State::kCancelledForGood, Action::kTakeStatus},
    Arrow{State::kCancelled, Event::kSettled, State::kFinished, Action::kFinish},

    Arrow{State::kCancelledForGood, Event::kOpened, State::kCancelledForGood,
          Action::kAttachSession},
    Arrow{State::kCancelledForGood, Event::kFailed, State::kCancelledForGood, Action::kTakeStatus},
    Arrow{State::kCancelledForGood, Event::kSettled, State::kFinished, Action::kFinish},
};

}  // namespace

StreamTransition Next(StreamState state, StreamEvent event) {
  return NextIn<StreamTransition>(kArrows, state, event);
}

StreamRules RulesOf(StreamState state) {
  switch (state) {
    case State::kAdmitting:
      return {};
    case State::kOpening:
      return {.reads = true, .writes = true};
    case State::kStreaming:
      return {.reads = true, .writes = true, .answers = true};
    case State::kDetaching:
      return {.writes = true,
              .answers = true,
              .keeps_session = true,
              .must_write = MustWrite::kWhatWasRead};
    case State::kDraining:
      return {.writes = true, .answers = true, .must_write = MustWrite::kWhatWasRead};
    case State::kFailing:
      return {.writes = true, .must_write = MustWrite::kWhatIsMade};
    case State::kCancelled:
      return {.keeps_session = true, .must_write = MustWrite::kNothing};
    case State::kCancelledForGood:
      return {.must_write = MustWrite::kNothing};
    case State::kFinished:
      return {};
  }
  return {};
}

}  // namespace dcloc::server
