#pragma once

namespace dcloc::server {

/// Where a Localize stream stands. README.md draws how they follow one another.
enum class StreamState {
  kOpening,           ///< no session yet: its first message is awaited, or worked on
  kStreaming,         ///< scans are read and answered
  kDetaching,         ///< half-closed by the client of a resumable session
  kDraining,          ///< closed by its client, or ended from here
  kFailing,           ///< refused, or its session was taken over
  kCancelled,         ///< the connection is gone, and the session may be resumed
  kCancelledForGood,  ///< the connection is gone, and the session has ended
  kFinished,          ///< Finish was called
};

/// What happens to a stream.
enum class StreamEvent {
  kFirstRead,  ///< the first message has come
  kScanRead,   ///< another message has come
  kClosed,     ///< the client ended its session: said so, or half-closed one that cannot be resumed
  kHalfClosed,  ///< the client of a resumable session sends no more on this stream
  kOpened,      ///< the session is open, or found again
  kFailed,      ///< a message ends the stream, or another stream has taken the session
  kEnded,       ///< the server ends the session
  kCancelled,   ///< nobody reads the answers any more
  kSettled,     ///< all that the state has to write is written
};

/// What a stream does about an event.
enum class StreamAction {
  kNone,
  kOpenSession,    ///< have the session opened
  kQueueScan,      ///< have the scan answered
  kAttachSession,  ///< take the session and answer that it is open
  kTakeStatus,     ///< keep the event's status for the end
  kFinish,         ///< let go of the session and finish the call
};

struct StreamTransition {
  StreamState state = StreamState::kOpening;
  StreamAction action = StreamAction::kNone;
};

/// What follows. An event that has no arrow in the table changes nothing.
StreamTransition Next(StreamState state, StreamEvent event);

/// What must have been written before a stream may finish.
enum class MustWrite {
  kEverything,   ///< it does not finish by itself
  kWhatWasRead,  ///< an answer to each message that was read
  kWhatIsMade,   ///< the answers that there are
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
