#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/pose_estimate.h"
#include "core/localizer/workspace.h"
#include "core/radar/static_points.h"
#include "core/registration/map_matcher.h"
#include "core/uncertainty/map_fit_monitor.h"

namespace dcloc {

/// Tests whether a scan lies in the map where the vehicle is predicted to be. Registration does not
/// ask that: it moves the pose until the scans fit (METHOD section 16).
template <int Dim>
class ScanChecker {
 public:
  ScanChecker(std::size_t radar_count, const MapFitOptions& options)
      : options_(options), monitor_(radar_count, options) {}

  /// The fit of a scan of radar `radar_index`, taken at `stamp` where the vehicle is predicted to
  /// be `now`, in the local map of `matcher`. `points` are its static points, vehicle frame.
  ScanFit Test(Stamp stamp, std::size_t radar_index, const std::vector<RadarPoint>& points,
               const PoseEstimate<Dim>& now, const MapMatcher<Dim>& matcher,
               Workspace<Dim>& workspace);

  /// What such a fit of `point_count` points of radar `radar_index` says.
  ScanFit Judge(std::size_t radar_index, std::size_t point_count, double fit) const {
    return monitor_.Judge(radar_index, point_count, fit);
  }

  /// How such points would fit where the vehicle may be, with as little certainty: [0, 1].
  double FitAt(const std::vector<RadarPoint>& points, const PoseEstimate<Dim>& pose,
               const MapMatcher<Dim>& matcher, Workspace<Dim>& workspace) const;

  /// That of the scan that was tested last, [0, 1].
  double last_fit() const { return last_.fit; }

  /// What the scans so far say together.
  FitTrend Trend() const { return monitor_.Trend(); }

  /// The vehicle surely was where the last scan was tested: it is what to expect.
  void Learn() { monitor_.Learn(last_.radar_index, last_.point_count, last_.fit); }

  /// The pose has been confirmed: scans that do not fit are counted anew.
  void OnConfirmed() { contradicted_since_.reset(); }

  /// It is at another place than before, or verified although scans did not fit.
  void Reset();

  /// Whether scans fit again since the last one, after some that did not. What those showed may
  /// have been in the way for a moment.
  bool agrees_again() const { return agrees_again_; }

  /// Of the scans of the last `span` before `stamp`, some are from before the first that did not
  /// fit, or from before scans fitted again: they speak of another time.
  bool IsTooSoonToJudge(Stamp stamp, std::chrono::nanoseconds span) const {
    return contradicted_since_ && stamp - *contradicted_since_ < span;
  }

 private:
  struct Tested {
    std::size_t radar_index = 0;
    std::size_t point_count = 0;
    double fit = 0.0;
  };
  MapFitOptions options_;
  MapFitMonitor monitor_;
  Tested last_;
  // The first scan that did not fit; or when scans fitted again, while that is to be verified.
  std::optional<Stamp> contradicted_since_;
  int agreeing_count_ = 0;  // in a row, since one did not fit
  bool agrees_again_ = false;
};

}  // namespace dcloc
