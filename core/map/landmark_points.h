#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/map/landmark_fusion.h"
#include "core/map/radar_map.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// Appends the static `points` (vehicle frame) of scan number `scan`, taken at `T_local_vehicle`,
/// to `returns`.
void AppendReturns(std::span<const RadarPoint> points, const Pose3& T_local_vehicle,
                   std::uint32_t scan, std::vector<MapReturn>& returns);

/// The record of a landmark in its keyframe's frame. With `has_heights` its z is the landmark's
/// height over the radars that saw it. Counts saturate.
MapPoint PointInKeyframe(const Landmark& landmark, const Pose3& T_local_keyframe, bool has_heights);

}  // namespace dcloc
