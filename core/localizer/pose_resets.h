#pragma once

#include "core/geometry/pose.h"

namespace dcloc {

/// Resets, changes of the answered pose that the vehicle did not make: a place found anew, a
/// correction of odometry, a large correction by registrations. What the vehicle has moved
/// meanwhile is no part of them.
struct PoseResets {
  int count = 0;
  /// The last one, in the vehicle frame: the pose without it, times this, is the pose with it. A
  /// controller that keeps a path undoes it.
  Pose3 T_before_after;
};

}  // namespace dcloc
