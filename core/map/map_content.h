#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "absl/status/status.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/map/map_file.h"

namespace dcloc {

/// Checks the meaning of everything but the points: ranges, unit rotations, that the keyframes
/// share the points out without gap or overlap, and that the index holds each keyframe once, in its
/// cell. DataLoss names the first fault.
absl::Status CheckContent(const MapFileView& view);

/// Finite values, positive semidefinite covariances. DataLoss names the first fault.
absl::Status CheckPoints(std::span<const MapPoint> points);

/// Whether a name or description may stand in a map: well-formed UTF-8 (the wire's strings must be)
/// without NUL, at most `max_bytes`.
bool IsMapText(std::string_view text, std::size_t max_bytes);

/// The anchor that `info` holds, if any.
std::optional<GeodeticAnchor> AnchorOf(const InfoRecord& info);

}  // namespace dcloc
