// How a scan lies in the map where the vehicle is predicted to be, and what that speaks for.
#include <numbers>

#include "core/localizer/pipeline.h"

namespace dcloc {

// How the scan lies in the map at `pose`, and what that is evidence of: its radar, the place.
template <int Dim>
ScanFit Pipeline<Dim>::TakeScanFit(Stamp stamp, std::size_t radar_index,
                                   const PoseEstimate<Dim>& pose, Workspace<Dim>& workspace) {
  const ScanFit fit = radars_.scan_checker.Test(stamp, radar_index, workspace.static_points, pose,
                                                map_.matcher, workspace);
  if (radars_.scan_checker.agrees_again()) {
    relocalizer_.ForgetViews();
    place_evidence_.Reset();
  }
  radars_.monitor.OnFit(radar_index, radars_.scan_checker.last_fit());
  TakePlaceEvidence(stamp, radar_index, pose.pose, workspace);
  return fit;
}

// The newest scan at the predicted pose. It speaks of the sources of odometry and the pose, too.
template <int Dim>
void Pipeline<Dim>::TestScanFit(Stamp stamp, std::size_t radar_index, Workspace<Dim>& workspace) {
  if (!tracking_.has_pose()) return;
  const ScanFit fit = TakeScanFit(stamp, radar_index, pose_.Now(), workspace);
  // A mean over a few points says little.
  const bool is_full =
      workspace.static_points.size() >= static_cast<std::size_t>(options_.map_fit.min_point_count);
  // What is compared is relative to the pose: where that is lost, both hypotheses are wrong.
  const bool is_comparable = is_full && !tracking_.is_lost();
  if (is_comparable && LearnAzimuthSign(radar_index, workspace)) return;
  if (is_comparable && LearnRangeBias(stamp, radar_index, workspace)) return;
  if (!IsTrusted(radar_index, stamp)) return;
  if (is_comparable) CompareSourcesByMapFit(radar_index, workspace);
  if (is_full) CompareAlongTrackRivals(radar_index, fit, workspace);
  UpdateTrackingByScanFit(fit);
}

// Where one radar's clock is ahead, all others come late: they tell that it does not fit. A pose
// that is to be confirmed is newer than they are.
template <int Dim>
void Pipeline<Dim>::TestLateScanFit(Stamp stamp, std::size_t radar_index,
                                    const MotionHistory::Moment& moment,
                                    Workspace<Dim>& workspace) {
  if (!tracking_.has_pose() || tracking_.is_to_be_confirmed()) return;
  const ScanFit fit = TakeScanFit(stamp, radar_index, PoseThen(moment), workspace);
  if (IsTrusted(radar_index, stamp)) UpdateTrackingByScanFit(fit);
}

// Points where the map has nothing are neither for nor against the place: it may end before them.
template <int Dim>
void Pipeline<Dim>::TakePlaceEvidence(Stamp stamp, std::size_t radar_index, const Pose<Dim>& pose,
                                      const Workspace<Dim>& workspace) {
  // A point's fit has the mean 1/2 in the plane, and 1/sqrt(8) in space.
  constexpr double kAsInPlane = Dim == 3 ? std::numbers::sqrt2 : 1.0;
  if (!IsTrusted(radar_index, stamp) || newest_.outcome != RegistrationOutcome::kAccepted) return;
  const std::span<const GaussianPoint<Dim>> points = workspace.scan_points;
  const std::size_t mapped_count =
      map_.matcher.CountMapped(points, pose, options_.place_evidence.mapped_m);
  if (mapped_count == 0) return;
  const double fit_sum = radars_.scan_checker.last_fit() * static_cast<double>(points.size());
  place_evidence_.OnScanFit(stamp, mapped_count,
                            kAsInPlane * fit_sum / static_cast<double>(mapped_count));
  const EvidenceForPlace evidence = place_evidence_.Judge();
  const bool waits = evidence == EvidenceForPlace::kEnough && !rivals_.stands_out();
  tracking_.OnPlaceEvidence(waits ? EvidenceForPlace::kTooLittle : evidence);
}

// A pose that stops to be confirmed is where the search begins, if there will be one.
template <int Dim>
void Pipeline<Dim>::UpdateTrackingByScanFit(ScanFit fit) {
  const bool was_confirmed = tracking_.mode() == TrackingMode::kConfirmed;
  const bool ground_repeats = rivals_.ground_repeats();
  const FitTrend trend = rivals_.has_better() ? FitTrend::kDeclined : radars_.scan_checker.Trend();
  tracking_.OnFitTrend(trend, ground_repeats);
  tracking_.OnScanFit(fit, ground_repeats);
  if (tracking_.mode() == TrackingMode::kConfirmed) {
    radars_.scan_checker.OnConfirmed();
    if (newest_.outcome == RegistrationOutcome::kAccepted && fit != ScanFit::kContradicts) {
      radars_.scan_checker.Learn();
    }
  } else if (was_confirmed) {
    relocalizer_.SetPrior(NowInMap());
  }
}

template void Pipeline<2>::TestScanFit(Stamp, std::size_t, Workspace<2>&);
template void Pipeline<3>::TestScanFit(Stamp, std::size_t, Workspace<3>&);
template void Pipeline<2>::TestLateScanFit(Stamp, std::size_t, const MotionHistory::Moment&,
                                           Workspace<2>&);
template void Pipeline<3>::TestLateScanFit(Stamp, std::size_t, const MotionHistory::Moment&,
                                           Workspace<3>&);

}  // namespace dcloc
