#include "core/localizer/scan_checker.h"

#include <algorithm>

#include "core/geometry/covariance.h"
#include "core/localizer/thin_points.h"

namespace dcloc {
namespace {

constexpr int kAgreeingScans = 3;  // in a row, that end a contradiction

}  // namespace

template <int Dim>
ScanFit ScanChecker<Dim>::Test(Stamp stamp, std::size_t radar_index,
                               const std::vector<RadarPoint>& points, const PoseEstimate<Dim>& now,
                               const MapMatcher<Dim>& matcher, Workspace<Dim>& workspace) {
  const double fit = FitAt(points, now, matcher, workspace);
  last_ = {.radar_index = radar_index, .point_count = workspace.scan_points.size(), .fit = fit};
  monitor_.Follow(radar_index, last_.point_count, last_.fit);
  const ScanFit verdict = monitor_.Judge(radar_index, last_.point_count, last_.fit);
  agrees_again_ = false;
  if (verdict == ScanFit::kContradicts) {
    agreeing_count_ = 0;
    if (!contradicted_since_) contradicted_since_ = stamp;
  } else if (verdict == ScanFit::kAgrees && contradicted_since_) {
    agrees_again_ = ++agreeing_count_ == kAgreeingScans;
    if (agrees_again_) contradicted_since_ = stamp;
  }
  return verdict;
}

template <int Dim>
double ScanChecker<Dim>::FitAt(const std::vector<RadarPoint>& points, const PoseEstimate<Dim>& pose,
                               const MapMatcher<Dim>& matcher, Workspace<Dim>& workspace) const {
  ThinPoints(points, options_.max_point_count, workspace.scan_points);
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
