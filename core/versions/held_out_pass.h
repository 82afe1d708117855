#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/passes/placed_landmark.h"
#include "core/passes/placed_pass.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/versions/map_replay.h"

namespace dcloc {

/// A pass that had no part in an update, where two versions of the map together put it.
struct HeldOutPass {
  /// At the consensus; the scans that both versions track, and those beyond the old version that
  /// the new one tracks.
  PlacedPass pass;
  std::vector<std::size_t> scans;  ///< of `pass.scans`: the number of the scan
  /// Of `pass.scans`: the new version's pose from the old one's; beyond that from where odometry
  /// alone has it.
  std::vector<Pose2> T_old_new;
};

/// Aligns the pass with the landmarks of each version and takes the middle of both, and the new one
/// beyond the old one, where nothing of `old_keyframes_m` is near. The replays are of `scans`;
/// landmarks and keyframes are relative to `origin_m` of the map. Empty where no scan is tracked in
/// both versions.
HeldOutPass PlaceInBoth(const Rig& rig, std::span<const Scan> scans,
                        std::span<const ReplayedScan> old_replay,
                        std::span<const ReplayedScan> new_replay,
                        std::span<const PlacedLandmark> old_landmarks,
                        std::span<const PlacedLandmark> new_landmarks,
                        std::span<const Eigen::Vector2d> old_keyframes_m,
                        const Eigen::Vector3d& origin_m);

}  // namespace dcloc
