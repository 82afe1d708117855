#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/localizer/localizer.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::cli {

/// What a recorded `open` says, as the server that took it understood it.
struct SessionStart {
  Rig rig;
  std::optional<InitialPose> initial_pose;
  LocalizerOptions options;
};

/// In a map with that anchor, if any. FailedPrecondition for a session that began with a GNSS fix
/// where the map has none.
absl::StatusOr<SessionStart> FromProto(const v1::OpenSession& open,
                                       const std::optional<GeodeticAnchor>& anchor);

/// As above for a position fix that the server took. FailedPrecondition for a GNSS fix where the
/// map has no anchor.
absl::StatusOr<PositionFix> FromProto(const v1::PositionFix& message,
                                      const std::optional<GeodeticAnchor>& anchor);

/// As above for a scan that the server localized.
Scan FromProto(const v1::Scan& message);

}  // namespace dcloc::cli
