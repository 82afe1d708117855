#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/map/landmark_fusion.h"
#include "core/passes/center_matching.h"
#include "core/passes/placed_landmark.h"

namespace dcloc {

/// One landmark in place of `base` of the base map and `fused` of later passes, which are of one
/// scatterer. Each weighs by the passes that saw it; the covariance is that of the mixture:
///
///   p = sum w_k p_k,   Sigma = sum w_k (Sigma_k + (p_k - p) (p_k - p)^T)                (64)
///
/// So a landmark that many passes saw hardly moves any more.
Landmark Blend(const PlacedLandmark& base, const Landmark& fused);

/// The landmarks of `base`, where one of `fused` is the same scatterer blended with it, and those
/// of `fused` that it has not: what all passes together make of the map. Only the places; `fused`
/// are relative to the map's local origin.
std::vector<LandmarkPosition> BlendedPositions(std::span<const PlacedLandmark> base,
                                               std::span<const Landmark> fused,
                                               const CenterMatchingOptions& options);

}  // namespace dcloc
