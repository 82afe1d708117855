#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/map/landmark_fusion.h"
#include "core/passes/center_matching.h"
#include "core/passes/placed_pass.h"

namespace dcloc {

/// What the scans that count of `passes` see, fused: scatterers by place, relative to `origin_m` of
/// the map. `pass_count` counts the passes that saw each. Seen by `min_scan_count` scans at least.
std::vector<Landmark> FusePasses(std::span<const PlacedPass* const> passes,
                                 const Eigen::Vector3d& origin_m, int min_scan_count,
                                 ScanChoice choice = ScanChoice::kAll);

LandmarkPosition PositionOf(const Landmark& landmark);
std::vector<LandmarkPosition> PositionsOf(std::span<const Landmark> landmarks);

}  // namespace dcloc
