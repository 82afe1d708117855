#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/map/landmark_fusion.h"
#include "core/passes/center_matching.h"

namespace dcloc {

/// How often a place where nothing stands is seen all the same: measured at decoys, places beside
/// the landmarks, with the centers that no landmark explains.
class FalseHits {
 public:
  double share = 0.05;  ///< of decoys that a pass sees
  double mean = 3.0;    ///< scans of those

  /// A pass that saw `seen`, where landmarks and others are at `positions`.
  void Add(std::span<const LandmarkPosition> positions, std::span<const Landmark> seen,
           const CenterMatchingOptions& options);

  /// Sets `share` and `mean`.
  void Finish();

 private:
  double decoys_ = 0.0;
  double hit_decoys_ = 0.0;
  double hits_ = 0.0;
};

}  // namespace dcloc
