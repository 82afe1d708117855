#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/map/map_parts.h"
#include "core/map/point_grid.h"
#include "core/radar/static_points.h"
#include "core/update/center_matching.h"
#include "core/update/map_replay.h"

namespace dcloc {

/// How one version localizes a pass that it was not made of. Its track is where it puts the
/// vehicle, smoothed by odometry (`ConsensusOf`).
struct VersionScore {
  double scatter_m = 0.0;  ///< of its poses about its own track, median
  double scatter_p90_m = 0.0;
  double offset_m = 0.0;        ///< of its track from that of what both versions have, median
  double tracking_share = 0.0;  ///< of the scans
  double nees = 0.0;            ///< of (x, y, yaw) about its track, by 3; median
  double fit = 0.0;  ///< mean of exp(-d^2 / 2) over static targets, on its track: likelihood
};

/// A landmark of a version in the plane of the map's local frame.
struct PlacedLandmark {
  PlaceEstimate place;
  std::size_t keyframe = 0;
  MapPoint point{};
};
std::vector<PlacedLandmark> LandmarksOf(const MapParts& map);

/// How static targets fit the landmarks of one version, wherever the vehicle is taken to be.
class FitScorer {
 public:
  explicit FitScorer(std::span<const PlacedLandmark> landmarks);

  /// The sum of exp(-d^2 / 2) over `points` (vehicle frame), each with its nearest landmark.
  double Sum(std::span<const RadarPoint> points, const Pose2& T_local_vehicle) const;

 private:
  std::vector<PlaceEstimate> places_;
  PointGrid grid_{1.0};
};

/// Gathers a version's score over some scans.
class ScoreSum {
 public:
  /// `track` is the version's own, `agreed` that of what both versions have.
  void Add(const ReplayedScan& scan, const std::optional<Pose2>& track, const Pose2& agreed);
  void AddFit(double sum, std::size_t point_count);
  VersionScore Score() const;

 private:
  std::size_t scan_count_ = 0;
  std::size_t tracking_count_ = 0;
  std::vector<double> scatter_m_;
  std::vector<double> offsets_m_;
  std::vector<double> nees_;
  double fit_ = 0.0;
  std::size_t point_count_ = 0;
};

}  // namespace dcloc
