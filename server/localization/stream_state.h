#pragma once

namespace dcloc::server {

/// The states of a Localize stream; README.md has the diagram.
enum class StreamState {
  kAdmitting,         ///< not known yet who calls; nothing is read
  kOpening,           ///< no session yet: its first message is awaited, or worked on
  kStreaming,         ///< scans are read and answered
  kDetaching,         ///< half-closed by the client of a resumable session
  kDraining,          ///< closed by its client, or ended by the server
  kFailing,           ///< refused, or its session was taken over
  kCancelled,         ///< the connection is gone, and the session may be resumed
  kCancelledForGood,  ///< the connection is gone, and the session has ended
  kFinished,          ///< Finish was called
};

/// What happens to a stream.
enum class StreamEvent {
  kAdmitted,    ///< the caller may localize
  kFirstRead,   ///< the first message has come
  kScanRead,    ///< another message has come
  kClosed,      ///< the client sent `close`, or half-closed a session that cannot be resumed
  kHalfClosed,  ///< the client of a resumable session sends no more on this stream
  kOpened,      ///< the session is open, or found again
  kFailed,      ///< a message ends the stream, or another stream has taken the session
  kEnded,       ///< the server ends the session
  kCancelled,   ///< the connection is gone, or a write failed
  kSettled,     ///< all that the state must write is written
};

/// What a stream does on an event.
enum class StreamAction {
  kNone,
  kOpenSession,    ///< have the session opened
  kQueueScan,      ///< have the scan answered
  kAttachSession,  ///< attach the session and tell the client that it is open
  kTakeStatus,     ///< keep the event's status for `Finish`
  kFinish,         ///< release the session and finish the call
};

struct StreamTransition {
  StreamState state = StreamState::kAdmitting;
  StreamAction action = StreamAction::kNone;
};

/// The transition from `state` by `event`. An event that has no arrow in the table changes nothing.
StreamTransition Next(StreamState state, StreamEvent event);

/// What must have been written before a stream may finish.
enum class MustWrite {
  kEverything,   ///< it does not finish on its own
  kWhatWasRead,  ///< an answer to each scan that was read
  kWhatIsMade,   ///< the answers that are ready
  kNothing,
};

/// What a state allows.
struct StreamRules {
  bool reads = false;          ///< a read may start
  bool writes = false;         ///< a write may start
  bool answers = false;        ///< scans that were read are answered
  bool keeps_session = false;  ///< when it finishes, a resumable session waits for its client
  MustWrite must_write = MustWrite::kEverything;
};

StreamRules RulesOf(StreamState state);

}  // namespace dcloc::server
