// What an answer says: the pose, what is claimed of it, and which hypotheses scans speak for.
#include <cmath>

#include "core/geometry/covariance.h"
#include "core/geometry/pose_estimate.h"
#include "core/localizer/pipeline.h"

namespace dcloc {

template <int Dim>
Localization Pipeline<Dim>::Answer(const Scan& scan, Stamp stamp) {
  Localization answer{.stamp = scan.stamp, .quality = quality_};
  answer.health = ReportHealth(stamp, ego_motion_, learned_rig_, radar_monitor_);
  if (knowledge_report_.IsDue(stamp)) answer.learned = knowledge_report_.OnKnown(Knowledge());
  answer.resets = reset_counter_.resets();
  answer.quality.live_point_count = static_cast<int>(submap_.point_count());
  answer.quality.beta = learner_.CheckBeta(learned_rig_.IndexOf(scan.radar_id));
  if (!tracking_.has_pose()) {
    answer.covariance = kUnknownVariance * Matrix6d::Identity();
    if (const std::optional<PoseEstimate<3>>& prior = relocalizer_.prior()) {
      answer.T_map_vehicle = prior->pose;
      answer.covariance = prior->covariance;
    }
    answer.state = tracking_.Report(HorizontalSigma(answer.covariance));
    return answer;
  }
  const PoseEstimate<3> now = ToSpace<Dim>(pose_.Now(), options_.unobserved);
  tracking_.OnPrediction(stamp, HorizontalSigma(now.covariance));
  answer.T_map_vehicle = matcher_.T_map_local() * now.pose;
  answer.covariance =
      ToSpace<Dim>({.pose = {}, .covariance = pose_.NoiseNow()}, options_.unobserved).covariance;
  Claim(answer);
  reset_counter_.OnAnswer(answer.T_map_vehicle);
  answer.resets = reset_counter_.resets();
  answer.observed = observability_.ObservedDof(/*in_space=*/Dim == 3);
  return answer;
}

// A stamp that is off by a time is a position that is off along the way (METHOD eq 54).
template <int Dim>
void Pipeline<Dim>::Claim(Localization& answer) {
  const EgoVelocity velocity = ego_motion_.velocity().value_or(EgoVelocity{});
  const double speed_mps = velocity.linear_mps.norm();
  const double doubt_m = speed_mps * stamp_error_.doubt_s;
  const double doubted_way_m = ego_motion_.doubted_way_m();
  answer.state =
      tracking_.Report(std::hypot(HorizontalSigma(answer.covariance), doubt_m, doubted_way_m));
  if (answer.state == LocalizationState::kTracking) {
    answer.protection_level_m = protection_level_.Of(
        answer.covariance, speed_mps * stamp_error_.bound_s + doubt_m + doubted_way_m);
  }
  Vector6d per_second;
  per_second << velocity.linear_mps, velocity.angular_radps;
  answer.covariance += std::pow(stamp_error_.sigma_s, 2) * per_second * per_second.transpose();
}

// METHOD eq 50. Where the vehicle really is, static points lie on landmarks: how they fit at the
// place by the sources in use and at the rival's tells which of the two is right.
template <int Dim>
void Pipeline<Dim>::CompareSourcesByMapFit(Workspace<Dim>& workspace) {
  const std::optional<Pose3> T_used_rival = ego_motion_.RivalPlace();
  if (!T_used_rival) return;
  // A mean over a few points says little.
  if (workspace.static_points.size() < static_cast<std::size_t>(options_.map_fit.min_point_count)) {
    return;
  }
  const Pose<Dim> used = pose_.Now().pose;
  const Pose<Dim> rival = used * FromSpace<Dim>(*T_used_rival, Matrix6d::Zero()).pose;
  const auto fit_at = [&](const Pose<Dim>& pose) {
    return scan_checker_.FitAt(workspace.static_points,
                               {.pose = pose, .covariance = TangentMatrix<Dim>::Zero()}, matcher_,
                               workspace);
  };
  ego_motion_.OnFits(fit_at(used), fit_at(rival));
}

// METHOD eq 57. A pose that begins is held against the places before and behind it.
template <int Dim>
void Pipeline<Dim>::CompareWayRivals(Workspace<Dim>& workspace) {
  const bool is_confirmed = tracking_.mode() == TrackingMode::kConfirmed;
  // Before a registration has been accepted, no place is where the vehicle may be.
  if (newest_outcome_ != RegistrationOutcome::kAccepted || !way_rivals_.IsDue(is_confirmed)) return;
  if (workspace.static_points.size() < static_cast<std::size_t>(options_.map_fit.min_point_count)) {
    return;
  }
  const double variance = 0.5 * std::pow(way_rivals_.pose_sigma_m(), 2);
  const auto fit_at = [&](double way_m) {
    Tangent<Dim> step = Tangent<Dim>::Zero();
    step(0) = way_m;
    return scan_checker_.FitAt(
        workspace.static_points,
        {.pose = pose_.Now().pose * Exp(step),
         .covariance = TangentMatrix<Dim>(variance * TangentMatrix<Dim>::Identity())},
        matcher_, workspace);
  };
  const double fit = fit_at(0.0);
  workspace.rival_fits.clear();
  for (const double way_m : way_rivals_.ways_m()) workspace.rival_fits.push_back(fit_at(way_m));
  way_rivals_.OnFits(workspace.scan_points.size(), is_confirmed, fit, workspace.rival_fits);
  if (!way_rivals_.Better()) return;
  way_rivals_.Reset();
  tracking_.OnRivalFits();
}

template <int Dim>
std::optional<double> Pipeline<Dim>::FitAt(const Scan& scan, Stamp stamp,
                                           LocalizerWorkspace& lent_workspace) {
  const std::optional<MotionHistory::Moment> moment = ego_motion_.history().AtOrSoonAfter(stamp);
  if (!moment || !tracking_.has_pose()) return std::nullopt;
  Workspace<Dim>& workspace = lent_workspace.Of<Dim>();
  StaticPoints(scan, learned_rig_.rig().radars[learned_rig_.IndexOf(scan.radar_id)],
               moment->velocity, EffectiveStaticPoints(options_), workspace.static_points);
  PoseEstimate<Dim> pose = pose_.Now();
  pose.pose =
      pose.pose * FromSpace<Dim>(moment->to_newest.T_from_to.Inverse(), Matrix6d::Zero()).pose;
  return scan_checker_.FitAt(workspace.static_points, pose, matcher_, workspace);
}

template Localization Pipeline<2>::Answer(const Scan&, Stamp);
template Localization Pipeline<3>::Answer(const Scan&, Stamp);
template void Pipeline<2>::CompareSourcesByMapFit(Workspace<2>& workspace);
template void Pipeline<3>::CompareSourcesByMapFit(Workspace<3>& workspace);
template void Pipeline<2>::CompareWayRivals(Workspace<2>& workspace);
template void Pipeline<3>::CompareWayRivals(Workspace<3>& workspace);
template void Pipeline<2>::Claim(Localization& answer);
template void Pipeline<3>::Claim(Localization& answer);
template std::optional<double> Pipeline<2>::FitAt(const Scan&, Stamp, LocalizerWorkspace&);
template std::optional<double> Pipeline<3>::FitAt(const Scan&, Stamp, LocalizerWorkspace&);

}  // namespace dcloc
