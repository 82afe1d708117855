#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "absl/status/status.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/map/map_file.h"

namespace dcloc {

/// Checks everything but the points: ranges of values, unit rotations, that each point belongs to
/// exactly one keyframe, and that the index has each keyframe once, in its cell. DataLoss names the
/// first fault.
absl::Status CheckContent(const MapFileView& view);

/// Finite values, positive semidefinite covariances. DataLoss names the first fault.
absl::Status CheckPoints(std::span<const MapPoint> points);

/// Whether a name or description may be stored in a map: well-formed UTF-8 (as protobuf demands)
/// without NUL, at most `max_bytes`.
bool IsMapText(std::string_view text, std::size_t max_bytes);

/// `MapInfo::stamp_delay_s` as `info` holds it; nothing where stamps are not known.
std::optional<double> StampDelayOf(const InfoRecord& info);
/// Sets it, in steps of a millisecond. Nothing or a number within +-kMaxStampDelay_s.
void SetStampDelay(std::optional<double> stamp_delay_s, InfoRecord& info);

/// The anchor that `info` holds, if any.
std::optional<GeodeticAnchor> AnchorOf(const InfoRecord& info);
/// Sets it; nothing takes it away.
void SetAnchor(const std::optional<GeodeticAnchor>& anchor, InfoRecord& info);

}  // namespace dcloc
