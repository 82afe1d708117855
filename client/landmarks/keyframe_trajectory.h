#pragma once

#include <cstddef>

#include "absl/status/statusor.h"
#include "client/trajectory/trajectory.h"
#include "core/map/editable_map.h"

namespace dcloc {

/// The keyframes as a trajectory. Maps know no times: the stamp is the keyframe's number in
/// seconds.
Trajectory KeyframeTrajectory(const EditableMap& map);

/// `base` with its keyframes where `trajectory` has them, each taking its landmarks along.
/// Keyframes within a micrometre and a microradian of the base's keep their bits. `moved_count`
/// tells how many do not. InvalidArgument for a trajectory without exactly the base's keyframes.
absl::StatusOr<EditableMap> MoveKeyframes(const EditableMap& base, const Trajectory& trajectory,
                                          std::size_t& moved_count);

}  // namespace dcloc
