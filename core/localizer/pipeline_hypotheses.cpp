// Which of two hypotheses scans speak for: both are laid into the map, and the one that is right
// fits it.
#include <algorithm>
#include <cmath>

#include "core/geometry/covariance.h"
#include "core/geometry/pose_estimate.h"
#include "core/geometry/thinning.h"
#include "core/localizer/pipeline.h"
#include "core/localizer/thin_points.h"

namespace dcloc {
namespace {

// As the radar would see the points if its azimuths had the other sign.
void MirrorAzimuths(const RadarModel& radar, std::vector<RadarPoint>& points) {
  const Eigen::Matrix3d R = radar.T_vehicle_radar.Rotation();
  const Eigen::Matrix3d mirror = R * Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal() * R.transpose();
  const Eigen::Vector3d& radar_m = radar.T_vehicle_radar.translation_m;
  for (RadarPoint& point : points) {
    point.position_m = radar_m + mirror * (point.position_m - radar_m);
    point.covariance_m2 = mirror * point.covariance_m2 * mirror.transpose();
    point.slant_per_m = (mirror.topLeftCorner<2, 2>() * point.slant_per_m).eval();
  }
}

void ReverseYawRate(Scan& scan) {
  scan.ego_velocity->angular_radps.z() *= -1.0;
  for (MotionTick& tick : scan.ticks) tick.yaw_rate_radps *= -1.0;
}

// What is left of a scan: its moment, and what the vehicle says of its motion.
Scan WithoutTargets(const Scan& scan) {
  return {.stamp = scan.stamp,
          .radar_id = scan.radar_id,
          .ego_velocity = scan.ego_velocity,
          .ticks = scan.ticks};
}

// How the road bends where the vehicle is, to the left.
double Curvature_radpm(const std::optional<EgoVelocity>& velocity) {
  constexpr double kMinSpeed_mps = 2.0;  // slower, the yaw rate is mostly noise
  if (!velocity || velocity->linear_mps.norm() < kMinSpeed_mps) return 0.0;
  const Eigen::Vector3d& v_mps = velocity->linear_mps;
  return velocity->angular_radps.z() / std::copysign(v_mps.norm(), v_mps.x());
}

// Nothing that a standing vehicle's radar sees moves, or hardly anything.
bool SeesMotion(const Scan& scan) {
  constexpr float kStanding_mps = 0.5F;
  const auto moving_count = std::ranges::count_if(scan.range_rate_mps, [](float range_rate_mps) {
    return std::abs(range_rate_mps) > kStanding_mps;
  });
  return static_cast<std::size_t>(2 * moving_count) > scan.size();
}

}  // namespace

// METHOD eq 50. Where the vehicle really is, static points lie on landmarks: how they fit at the
// place by the sources in use and at the alternative's shows which of the two is right.
template <int Dim>
void Pipeline<Dim>::CompareSourcesByMapFit(std::size_t radar_index, Workspace<Dim>& workspace) {
  const std::optional<EgoMotion::AlternativePlace> other = ego_motion_.Alternative(radar_index);
  if (!other) return;
  const Pose<Dim> used = pose_.Now().pose;
  const Pose<Dim> alternative =
      used * FromSpace<Dim>(other->T_used_alternative, Matrix6d::Zero()).pose;
  const auto fit_at = [&](const Pose<Dim>& pose) {
    return radars_.scan_checker.FitAt(workspace.static_points,
                                      {.pose = pose, .covariance = TangentMatrix<Dim>::Zero()},
                                      map_.matcher, workspace);
  };
  ego_motion_.OnFits(radar_index, *other, fit_at(used), fit_at(alternative));
}

// METHOD eq 60. The pose is held against some of the places before and behind it.
template <int Dim>
void Pipeline<Dim>::CompareAlongTrackRivals(std::size_t radar_index, ScanFit fit,
                                            Workspace<Dim>& workspace) {
  // Before a registration has been accepted, no place is where the vehicle may be.
  if (newest_.outcome != RegistrationOutcome::kAccepted) return;
  const bool fits_as_usual =
      fit == ScanFit::kAgrees && radars_.scan_checker.Trend() == FitTrend::kUsual;
  const bool in_doubt = !fits_as_usual || tracking_.mode() != TrackingMode::kConfirmed;
  if (!rivals_.IsDue(radar_index, in_doubt)) return;
  const std::span<const Pose2> T_vehicle_places =
      rivals_.NextPlaces(Curvature_radpm(ego_motion_.velocity()));
  if (T_vehicle_places.empty()) return;
  ThinPoints(workspace.static_points, rivals_.max_point_count(), workspace.scan_points);
  map_.matcher.FitsAt(T_vehicle_places, workspace.scan_points, pose_.Now().pose,
                      rivals_.pose_sigma_m(), workspace.registration, workspace.rival_fits);
  rivals_.OnFits(workspace.scan_points.size(), workspace.rival_fits);
  // Beside a scan that fits too little, any place fits well.
  if (fits_as_usual) rivals_.LearnRepetition(workspace.rival_fits);
}

// METHOD section 19. Rivals are registered like the pose, and what counts is which of them fits.
template <int Dim>
void Pipeline<Dim>::RegisterAlongTrackRivals(double pose_score, Workspace<Dim>& workspace) {
  std::vector<GaussianPoint<Dim>>& points = workspace.thinned_submap;
  points.clear();
  for (int i = rivals_.CountToRegister(); i > 0; --i) {
    const std::optional<Pose2> T_vehicle_place = rivals_.NextToRegister();
    if (!T_vehicle_place) return;
    if (points.empty()) {
      TakeEvenly(workspace.submap.points, rivals_.max_registered_point_count(),
                 [&](const GaussianPoint<Dim>& point) { points.push_back(point); });
    }
    const auto rival = map_.matcher.RegisterPlace(points, pose_.Now().pose, *T_vehicle_place,
                                                  workspace.registration);
    rivals_.OnRegistered(rival.T_vehicle_place, rival.score - pose_score);
  }
}

// METHOD eq 60. The scan is held against its mirror image. Where that fits better, the pose itself
// may be wrong instead: so both are laid at other poses, too, and the best fit of each counts.
template <int Dim>
bool Pipeline<Dim>::LearnAzimuthSign(std::size_t radar_index, Workspace<Dim>& workspace) {
  if (!radars_.azimuth_signs.IsDue(radar_index)) return false;
  const AzimuthSignOptions& options = radars_.azimuth_signs.options();
  const PoseEstimate<Dim> now = pose_.Now();
  const double sigma_m = std::clamp(HorizontalSigma(now.covariance), options.min_pose_sigma_m,
                                    options_.map_fit.max_prediction_sigma_m);
  const auto fit_at_pose = [&](const std::vector<RadarPoint>& points) {
    ThinPoints(points, options.max_point_count, workspace.scan_points);
    return map_.matcher.Fit(workspace.scan_points, now.pose, sigma_m, workspace.registration);
  };
  const auto best_fit = [&](const std::vector<RadarPoint>& points) {
    ThinPoints(points, options.max_point_count, workspace.scan_points);
    map_.matcher.FitsAt(radars_.azimuth_signs.T_vehicle_poses(), workspace.scan_points, now.pose,
                        sigma_m, workspace.registration, workspace.rival_fits);
    return std::ranges::max(workspace.rival_fits);
  };

  // As many as are laid into the map.
  workspace.tried_points.clear();
  TakeEvenly(workspace.static_points, options.max_point_count,
             [&](const RadarPoint& point) { workspace.tried_points.push_back(point); });
  MirrorAzimuths(radars_.learned.rig().radars[radar_index], workspace.tried_points);
  double fit = fit_at_pose(workspace.static_points);
  double mirrored_fit = fit_at_pose(workspace.tried_points);
  if (mirrored_fit > fit) {
    fit = best_fit(workspace.static_points);
    mirrored_fit = best_fit(workspace.tried_points);
  }
  if (!radars_.azimuth_signs.OnFits(radar_index, workspace.scan_points.size(), fit, mirrored_fit)) {
    return false;
  }
  OnAzimuthSignChanged(radar_index);
  workspace.static_points.clear();
  return true;
}

template <int Dim>
void Pipeline<Dim>::TryOtherAzimuthSigns() {
  for (std::size_t i = 0; i < rig().radars.size(); ++i) {
    if (radars_.azimuth_signs.TryOther(i)) OnAzimuthSignChanged(i);
  }
}

// What was seen with the other sign is not where it was put.
template <int Dim>
void Pipeline<Dim>::OnAzimuthSignChanged(std::size_t radar_index) {
  live_.submap.DropPoints(static_cast<int>(radar_index));
  radars_.scan_checker.Reset();
  radars_.monitor.ResetFits();
  relocalizer_.RetakeViews();
}

// METHOD eq 71. The scan is laid into the map with shorter and longer ranges, each at the pose that
// would absorb most of that.
template <int Dim>
bool Pipeline<Dim>::LearnRangeBias(Stamp stamp, std::size_t radar_index,
                                   Workspace<Dim>& workspace) {
  RangeBiases& biases = radars_.range_biases;
  const RangeBiasOptions& options = biases.options();
  const bool is_where_it_seems = tracking_.mode() == TrackingMode::kConfirmed &&
                                 newest_.outcome == RegistrationOutcome::kAccepted;
  if (!is_where_it_seems || !EffectiveStaticPoints(options_).compensate ||
      !biases.IsDue(radar_index, workspace.static_points.size())) {
    return false;
  }
  const PoseEstimate<Dim> now = pose_.Now();
  const double sigma_m =
      std::min(options_.map_fit.max_prediction_sigma_m, HorizontalSigma(now.covariance));
  const std::vector<GaussianPoint<Dim>>& points = workspace.scan_points;
  ThinPoints(workspace.static_points, options.max_point_count, workspace.scan_points);
  const Eigen::Vector2d radar_m =
      rig().radars[radar_index].T_vehicle_radar.translation_m.template head<2>();
  const double by_pose_m =
      ShiftsByRange<Dim>(points, radar_m, options.landmark_sigma_m, workspace.range_shifts_m);
  const auto fit_longer_by = [&](double longer_m) {
    workspace.shifted_points = points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      workspace.shifted_points[i].mean_m.template head<2>() +=
          longer_m * workspace.range_shifts_m[i];
    }
    return map_.matcher.Fit(workspace.shifted_points, now.pose, sigma_m, workspace.registration);
  };
  const double absorbed_m = IsTrusted(radar_index, stamp) ? by_pose_m : 0.0;
  const std::optional<double> corrected_m =
      biases.OnFits(radar_index,
                    {.point_count = points.size(),
                     .shorter = fit_longer_by(-options.step_m),
                     .as_measured = fit_longer_by(0.0),
                     .longer = fit_longer_by(options.step_m)},
                    absorbed_m);
  if (!corrected_m) return false;
  Motion absorbed;
  absorbed.covariance.template topLeftCorner<2, 2>() =
      std::pow(*corrected_m * absorbed_m, 2) * Eigen::Matrix2d::Identity();
  pose_.OnMotion(absorbed);
  OnRangeCorrected(radar_index);
  workspace.static_points.clear();
  return true;
}

template <int Dim>
void Pipeline<Dim>::TryOtherRangeBiases() {
  if (!radars_.range_biases.TryOther()) return;
  for (std::size_t i = 0; i < rig().radars.size(); ++i) OnRangeCorrected(i);
  relocalizer_.RetakeViews();
}

// The search begins anew, so that views are taken as often as at the start.
template <int Dim>
void Pipeline<Dim>::GuessRangeBiases() {
  radars_.range_biases.Guess();
  for (std::size_t i = 0; i < rig().radars.size(); ++i) OnRangeCorrected(i);
  relocalizer_.ForgetViews();
}

// What was seen with other ranges is not where it was put.
template <int Dim>
void Pipeline<Dim>::OnRangeCorrected(std::size_t radar_index) {
  radars_.learned.CorrectRange(radar_index, radars_.range_biases.bias_m(radar_index));
  live_.submap.DropPoints(static_cast<int>(radar_index));
  radars_.scan_checker.Reset();
  radars_.monitor.ResetFits();
}

// Where nothing moves, the same targets may really be seen again.
template <int Dim>
const Scan& Pipeline<Dim>::Fresh(const Scan& sent, std::size_t radar_index,
                                 Workspace<Dim>& workspace) {
  constexpr double kStanding_mps = 0.5;
  const std::optional<EgoVelocity>& velocity = ego_motion_.velocity();
  const bool moves = velocity && velocity->linear_mps.norm() > kStanding_mps;
  const bool repeats =
      radars_.repeated_targets.OnScan(radar_index, sent) && (moves || SeesMotion(sent));
  radars_.monitor.ReportRepeats(radar_index, repeats);
  if (!repeats) return sent;
  workspace.fresh_scan = WithoutTargets(sent);
  return workspace.fresh_scan;
}

template <int Dim>
void Pipeline<Dim>::LearnRangeRateOffset(const Scan& scan, Stamp stamp, std::size_t radar_index) {
  if (!radars_.range_rate_offsets.OnScan(stamp, radar_index, scan, rig().radars[radar_index])) {
    return;
  }
  radars_.range_rate_errors.OnOffsetCorrected(radar_index);
  ego_motion_.OnRangeRatesCorrected();
}

template <int Dim>
const Scan& Pipeline<Dim>::Corrected(const Scan& scan, Workspace<Dim>& workspace) const {
  const std::size_t radar_index = radars_.learned.IndexOf(scan.radar_id);
  const bool is_mirrored = radars_.azimuth_signs.IsMirrored(radar_index);
  RangeRateError error = radars_.range_rate_errors.Learned(radar_index);
  if (error.is_compensated()) error = {};  // see AsMeasured
  error.offset_mps += radars_.range_rate_offsets.offset_mps(radar_index);
  const bool is_off = !error.is_none();
  const bool turns_other_way = ego_motion_.yaw_rate_is_reversed() && scan.ego_velocity.has_value();
  if (!is_mirrored && !is_off && !turns_other_way) return scan;
  workspace.corrected_scan = scan;
  if (is_off) CorrectRangeRates(error, workspace.corrected_scan);
  if (is_mirrored) {
    for (float& azimuth_rad : workspace.corrected_scan.azimuth_rad) azimuth_rad = -azimuth_rad;
  }
  if (turns_other_way) ReverseYawRate(workspace.corrected_scan);
  return workspace.corrected_scan;
}

template <int Dim>
const Scan& Pipeline<Dim>::TellingMotion(const Scan& scan, Workspace<Dim>& workspace) const {
  if (radars_.range_rate_errors.TellsMotion(radars_.learned.IndexOf(scan.radar_id))) return scan;
  workspace.motionless_scan = WithoutTargets(scan);
  return workspace.motionless_scan;
}

template <int Dim>
const Scan& Pipeline<Dim>::AsMeasured(const Scan& scan, const EgoVelocity& ego_velocity,
                                      Workspace<Dim>& workspace) const {
  const std::size_t radar_index = radars_.learned.IndexOf(scan.radar_id);
  if (radars_.range_rate_errors.TellsMotion(radar_index)) return scan;
  workspace.measured_scan = scan;
  AddEgoMotion(rig().radars[radar_index], ego_velocity, workspace.measured_scan);
  return workspace.measured_scan;
}

template const Scan& Pipeline<2>::Fresh(const Scan&, std::size_t, Workspace<2>&);
template const Scan& Pipeline<3>::Fresh(const Scan&, std::size_t, Workspace<3>&);
template void Pipeline<2>::CompareSourcesByMapFit(std::size_t, Workspace<2>&);
template void Pipeline<3>::CompareSourcesByMapFit(std::size_t, Workspace<3>&);
template void Pipeline<2>::CompareAlongTrackRivals(std::size_t, ScanFit, Workspace<2>&);
template void Pipeline<3>::CompareAlongTrackRivals(std::size_t, ScanFit, Workspace<3>&);
template void Pipeline<2>::RegisterAlongTrackRivals(double, Workspace<2>&);
template void Pipeline<3>::RegisterAlongTrackRivals(double, Workspace<3>&);
template bool Pipeline<2>::LearnAzimuthSign(std::size_t, Workspace<2>&);
template bool Pipeline<3>::LearnAzimuthSign(std::size_t, Workspace<3>&);
template bool Pipeline<2>::LearnRangeBias(Stamp, std::size_t, Workspace<2>&);
template bool Pipeline<3>::LearnRangeBias(Stamp, std::size_t, Workspace<3>&);
template void Pipeline<2>::TryOtherRangeBiases();
template void Pipeline<3>::TryOtherRangeBiases();
template void Pipeline<2>::GuessRangeBiases();
template void Pipeline<3>::GuessRangeBiases();
template void Pipeline<2>::TryOtherAzimuthSigns();
template void Pipeline<3>::TryOtherAzimuthSigns();
template const Scan& Pipeline<2>::TellingMotion(const Scan&, Workspace<2>&) const;
template const Scan& Pipeline<3>::TellingMotion(const Scan&, Workspace<3>&) const;
template const Scan& Pipeline<2>::AsMeasured(const Scan&, const EgoVelocity&, Workspace<2>&) const;
template const Scan& Pipeline<3>::AsMeasured(const Scan&, const EgoVelocity&, Workspace<3>&) const;
template void Pipeline<2>::LearnRangeRateOffset(const Scan&, Stamp, std::size_t);
template void Pipeline<3>::LearnRangeRateOffset(const Scan&, Stamp, std::size_t);
template const Scan& Pipeline<2>::Corrected(const Scan&, Workspace<2>&) const;
template const Scan& Pipeline<3>::Corrected(const Scan&, Workspace<3>&) const;

}  // namespace dcloc
