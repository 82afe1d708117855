#pragma once

#include <array>
#include <cstddef>

#include "absl/status/status.h"
#include "core/radar/stamp.h"
#include "core/relocalization/initial_pose.h"

namespace dcloc {

/// Where something else than radar says that the vehicle was: a satellite receiver, an operator.
struct PositionFix {
  Stamp stamp;  ///< on the clock of the scans
  /// As wide as it is not known: a receiver's heading has a variance of pi^2 / 3. What its errors
  /// have in common over time is no part of it.
  InitialPose pose;
};

/// What became of a fix.
enum class FixUse : std::size_t {
  kFused,               ///< it agrees with the pose, which has moved and is more certain by it
  kConsistentNotFused,  ///< it agrees with the pose, which stays as it was: the pose is much more
                        ///< certain, or another fix was fused less than `fusion_interval` ago
  kGuidesSearch,        ///< there is no pose: the search begins around it
  kContradicted,        ///< the radars say otherwise, and the pose stays; if fixes that are far off
                        ///< follow one another, the pose is held against theirs
  kOutOfTime,  ///< it is from before the last moments, or from after the newest scan by too much
};
inline constexpr std::array<const char*, 5> kFixUseNames = {"fused", "agrees", "guides search",
                                                            "contradicted", "out of time"};

/// OK, or InvalidArgument that names what is no pose or no covariance.
inline absl::Status Validate(const PositionFix& fix) { return Validate(fix.pose); }

}  // namespace dcloc
