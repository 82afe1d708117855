#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "core/map/point_grid.h"
#include "core/passes/placed_landmark.h"
#include "core/radar/static_points.h"
#include "core/versions/map_replay.h"

namespace dcloc {

/// How one version localizes a pass that it was not made of. The consensus is where the vehicle
/// was by both versions together (`EvaluateUpdate`).
struct VersionScore {
  double error_m = 0.0;  ///< of its answers that track, from the consensus, median
  double error_p90_m = 0.0;
  double offset_m = 0.0;        ///< of its landmarks, as the pass sees them: see `EvaluateUpdate`
  double tracking_share = 0.0;  ///< of the scans
  double nees = 0.0;            ///< of (x, y, yaw) about the consensus, by 3; median
  double fit = 0.0;             ///< mean of exp(-d^2 / 2) over static targets: likelihood
};

/// How static targets fit the landmarks of one version, wherever the vehicle is taken to be.
class FitScorer {
 public:
  explicit FitScorer(std::span<const PlacedLandmark> landmarks);

  /// The sum of exp(-d^2 / 2) over `points` (vehicle frame), each with its nearest landmark.
  double Sum(std::span<const RadarPoint> points, const Pose2& T_local_vehicle) const;

 private:
  std::vector<LandmarkPosition> positions_;
  PointGrid grid_{1.0};
};

/// Gathers a version's score over some scans.
class ScoreSum {
 public:
  void Add(const ReplayedScan& scan, const Pose2& T_map_consensus);
  /// A scan without a consensus: whether it is tracked.
  void AddTracking(bool is_tracking);
  /// `T_old_version` is where the version's landmarks put the vehicle, seen from where the old
  /// version's do.
  void AddOffset(const Pose2& T_old_version);
  void AddFit(double sum, std::size_t point_count);
  VersionScore Score() const;

 private:
  std::size_t scan_count_ = 0;
  std::size_t tracking_count_ = 0;
  std::vector<double> errors_m_;
  std::vector<double> offsets_m_;
  std::vector<double> nees_;
  double fit_ = 0.0;
  std::size_t point_count_ = 0;
};

}  // namespace dcloc
