#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/registration/likelihood_field.h"

namespace dcloc {

/// The part of the pose space to search, around a centre.
struct SearchWindow {
  Pose2 centre_local_vehicle;
  double translation_m = 1.0;  ///< half-width in x and in y
  double rotation_rad = 0.1;   ///< half-width; pi is every heading
};

/// One candidate pose with its likelihood score, [0, 1].
struct PoseCandidate {
  Pose2 T_local_vehicle;
  double score = 0.0;
};

/// Up to `max_count` best poses of `points` (vehicle xy) in the window, best first, no two within
/// four grid steps of one another in position and in angle (METHOD 5: correlative search).
/// Exhaustive; the step is one grid cell, and the angle that moves the farthest points by about two
/// cells.
std::vector<PoseCandidate> CorrelativeSearch(std::span<const Eigen::Vector2f> points,
                                             const LikelihoodField& field,
                                             const SearchWindow& window, int max_count);

}  // namespace dcloc
