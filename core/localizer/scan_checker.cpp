#include "core/localizer/scan_checker.h"

#include <algorithm>

#include "core/geometry/covariance.h"
#include "core/geometry/thinning.h"

namespace dcloc {
namespace {

// Up to `max_count` of a scan's points, evenly among them.
template <int Dim>
void TakeEvenly(const std::vector<RadarPoint>& scan, std::size_t max_count,
                std::vector<GaussianPoint<Dim>>& points) {
  const std::size_t count = std::min(scan.size(), max_count);
  points.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const RadarPoint& point = scan[EvenIndex(i, count, scan.size())];
    points.push_back({.mean_m = point.position_m.head<Dim>(),
                      .covariance_m2 = point.covariance_m2.topLeftCorner<Dim, Dim>()});
    if constexpr (Dim == 2) points.back().slant_per_m = point.slant_per_m;
  }
}

}  // namespace

template <int Dim>
ScanFit ScanChecker<Dim>::Test(Stamp stamp, std::size_t radar_index,
                               const std::vector<RadarPoint>& points, const PoseEstimate<Dim>& now,
                               const MapMatcher<Dim>& matcher, Workspace<Dim>& workspace) {
  const double fit = FitAt(points, now, matcher, workspace);
  last_ = {.radar_index = radar_index, .point_count = workspace.scan_points.size(), .fit = fit};
  monitor_.Follow(radar_index, last_.point_count, last_.fit);
  const ScanFit verdict = monitor_.Judge(radar_index, last_.point_count, last_.fit);
  if (verdict == ScanFit::kContradicts && !contradicted_since_) contradicted_since_ = stamp;
  return verdict;
}

template <int Dim>
double ScanChecker<Dim>::FitAt(const std::vector<RadarPoint>& points, const PoseEstimate<Dim>& pose,
                               const MapMatcher<Dim>& matcher, Workspace<Dim>& workspace) const {
  TakeEvenly(points, static_cast<std::size_t>(options_.max_point_count), workspace.scan_points);
  const double sigma_m = HorizontalSigma(pose.covariance);
  return matcher.Fit(workspace.scan_points, pose.pose,
                     std::min(options_.max_prediction_sigma_m, sigma_m), workspace.registration);
}

template <int Dim>
void ScanChecker<Dim>::Reset() {
  monitor_.Reset();
  contradicted_since_.reset();
}

template class ScanChecker<2>;
template class ScanChecker<3>;

}  // namespace dcloc
