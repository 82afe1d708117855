#pragma once

namespace dcloc::server {

/// Whether and how a stream is attached to a session.
enum class AttachmentState {
  kAttached,   ///< a stream has it
  kEnding,     ///< a stream has it, and was told to end it
  kDetached,   ///< it waits for its client
  kAbandoned,  ///< its stream was told to end, but broke first
  kEnded,      ///< it is in no list any more; why it ended is remembered
};

enum class AttachmentEvent {
  kAttach,   ///< a stream resumes it, or takes it over
  kDetach,   ///< its stream ends, and the session waits
  kClose,    ///< its stream ends, and the session with it
  kEnd,      ///< an operator, or its idleness, ends it
  kOverdue,  ///< its stream was told to end it, and has not
  kExpire,   ///< it waited for its client for too long
  kEvict,    ///< another session needs its place
  kDrain,    ///< the server stops, so that nobody can resume it here
};

enum class AttachmentAction {
  kNone,
  kTakeStream,   ///< the new stream has it; the former one, if any, is to be told
  kRefuse,       ///< it cannot be resumed any more
  kDropStream,   ///< no stream has it
  kTellStream,   ///< its stream is to end
  kAbortStream,  ///< its stream is cut off
  kRelease,      ///< it leaves the registry
};

struct AttachmentTransition {
  AttachmentState state = AttachmentState::kAttached;
  AttachmentAction action = AttachmentAction::kNone;
};

/// The transition from `state` by `event`. An event that has no arrow in the table changes nothing.
AttachmentTransition Next(AttachmentState state, AttachmentEvent event);

/// No stream has it, and it waits.
inline bool IsDetached(AttachmentState state) {
  return state == AttachmentState::kDetached || state == AttachmentState::kAbandoned;
}

}  // namespace dcloc::server
