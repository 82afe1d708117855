#pragma once

namespace dcloc::load {

/// How far a simulated vehicle is with its run.
enum class VehicleState {
  kDriving,    ///< one trip after another
  kFinishing,  ///< sends no further scans; ends once all that were sent are answered
  kCancelled,  ///< ends with its stream, whatever is not answered
  kDone,       ///< begins nothing more
};

/// What brings a vehicle's run to its end.
enum class VehicleEvent { kFinish, kCancel, kEnd };

/// The state after `event`. An event that has no arrow in the table changes nothing.
VehicleState Next(VehicleState state, VehicleEvent event);

/// The stream of a vehicle's session, from its opening message until it has ended.
enum class StreamState {
  kOpening,    ///< the server has not said yet that the session is open
  kReopening,  ///< the same, and the stream before it was cut on purpose
  kOpen,       ///< scans are sent and answered
  kCut,        ///< cut on purpose; its end is awaited
  kClosing,    ///< `close` was sent
};

/// What happens to a stream.
enum class StreamEvent {
  kBegin,   ///< the next stream begins
  kOpened,  ///< the server says that the session is open
  kCut,     ///< the load test cuts the connection
  kClose,   ///< the vehicle sends `close`
};

/// The state after `event`. An event that has no arrow in the table changes nothing.
StreamState Next(StreamState state, StreamEvent event);

/// Whether the server has said on this stream that the session is open.
bool WasOpened(StreamState state);

/// Whether it is a cut's doing if the stream fails: from the cut until the session is open again.
bool FollowsCut(StreamState state);

}  // namespace dcloc::load
