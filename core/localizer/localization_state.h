#pragma once

namespace dcloc {

/// What an answer claims of its pose. `TrackingStateMachine` decides.
enum class LocalizationState {
  kInitializing,  ///< no pose in the map is confirmed: at the start, or after a search found a
                  ///< place
  /// The last registrations agree with the estimate, and it is certain enough.
  kTracking,
  /// Held by ego-motion from a pose that was confirmed: the last registrations were not accepted,
  /// scans or fixes contradict it, the along-track position is not observed, as in a tunnel, or it
  /// is less certain than tracking asks for.
  kDeadReckoning,
  /// Nothing has confirmed the pose for about a second, or it is no longer known to two metres: it
  /// goes on by ego-motion, and the covariance grows until the map confirms a pose again. Where the
  /// prediction is too uncertain for that, the map is searched.
  kLost,
};

}  // namespace dcloc
