#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/passes/center_matching.h"
#include "core/passes/pass_track.h"
#include "core/passes/placed_landmark.h"
#include "core/passes/placed_pass.h"

namespace dcloc {

struct PassAlignmentOptions {
  CenterMatchingOptions matching;
  PassTrackOptions track;
  int min_center_scans = 3;  ///< of a center that is compared with landmarks
  int rounds = 4;            ///< of fusing, matching and moving
  int joint_rounds = 2;      ///< of aligning all passes with what they show together
  /// Deviations of the poses beyond the map in the rounds before, one after the other.
  std::vector<double> beyond_pose_m = {1.0, 1.0, 1.0, 0.5, 0.25};
  // Of the poses beyond the map that came out of it, for the joint rounds.
  double beyond_sigma_m = 1.0;
  double beyond_sigma_rad = 0.05;
};

/// What a pass is aligned with, relative to the origin of the map.
struct AlignmentTargets {
  std::span<const LandmarkPosition> landmarks;
  /// What other passes saw beyond the map; odometry may have put this one some metres beside it.
  std::span<const LandmarkPosition> beyond_map;
};

/// Refines the poses of the scans of `pass` that count: the centers that the pass sees come to lie
/// where `targets` lie, as far as its odometry allows (equation 63).
///
/// Centers and landmarks are both fused of many returns, in the same way. So what puts single scans
/// to one side of landmarks, and with them the localizer's poses, does not enter.
void AlignPass(const AlignmentTargets& targets, const Eigen::Vector3d& origin_m,
               const PassAlignmentOptions& options, PlacedPass& pass);

/// Aligns each of `passes` with the landmarks of `base` and with what those before it saw beyond
/// the map; and then all of them with what they and the map together show, so that no single pass,
/// the one of the base map neither, decides where landmarks lie. The frame stays that of the base
/// map.
void AlignPasses(std::span<const PlacedLandmark> base, const Eigen::Vector3d& origin_m,
                 const PassAlignmentOptions& options, std::span<PlacedPass> passes);

}  // namespace dcloc
