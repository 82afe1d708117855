#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/relocalization/initial_pose.h"
#include "dcloc/v1/localization_service.pb.h"

/// What clients say of a vehicle's pose, before the first scan or later. `field` is the path of the
/// message, for errors.
namespace dcloc::server::convert {

absl::StatusOr<InitialPose> FromProto(const v1::PoseWithCovariance& message,
                                      absl::string_view field);

/// The fix as a pose in a map with that anchor; FailedPrecondition where the map has none.
absl::StatusOr<InitialPose> FromProto(const v1::GnssFix& message,
                                      const std::optional<GeodeticAnchor>& anchor,
                                      absl::string_view field);

}  // namespace dcloc::server::convert
