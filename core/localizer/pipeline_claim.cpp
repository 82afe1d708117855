// What an answer says: the pose, and what is claimed of it.
#include <algorithm>
#include <cmath>

#include "core/geometry/covariance.h"
#include "core/geometry/pose_estimate.h"
#include "core/localizer/pipeline.h"

namespace dcloc {
template <int Dim>
Localization Pipeline<Dim>::FinishScan(const Scan& scan, Stamp stamp) {
  if (tracking_.has_pose()) {
    const double moved_m = claims_.reset_counter.OnAnswer(NowInMap().pose);
    if (moved_m > claims_.expected_change_m) claims_.protection_level.OnContradiction(moved_m);
  }
  Localization answer = Answer(scan, stamp);
  claims_.expected_change_m = claims_.protection_level.Usual(answer.covariance);
  if (claims_.knowledge_report.IsDue(stamp))
    answer.learned = claims_.knowledge_report.OnKnown(Knowledge());
  return answer;
}

// Nobody knows whether the vehicle went on for `lead`.
template <int Dim>
Localization Pipeline<Dim>::LocalizeUntimed(const Scan& scan, Stamp newest,
                                            std::chrono::nanoseconds lead) {
  Localization answer = FinishScan(scan, newest);
  const double lead_s = SecondsOf(lead);
  const EgoVelocity velocity = ego_motion_.velocity().value_or(EgoVelocity{});
  Vector6d way;
  way << velocity.linear_mps * lead_s, velocity.angular_radps * lead_s;
  answer.covariance += way * way.transpose();
  answer.protection_level_m.reset();
  answer.state = tracking_.Report(HorizontalSigma(answer.covariance));
  return answer;
}

template <int Dim>
void Pipeline<Dim>::ExpireTimeouts(Stamp stamp) {
  if (!tracking_.has_pose()) return;
  const PoseEstimate<3> now = ToSpace<Dim>(pose_.Now(), options_.unobserved);
  tracking_.ExpireTimeouts(stamp, HorizontalSigma(now.covariance));
}

template <int Dim>
Localization Pipeline<Dim>::Answer(const Scan& scan, Stamp stamp) const {
  Localization answer{.stamp = scan.stamp, .quality = newest_.quality};
  answer.health =
      ReportHealth(stamp, ego_motion_, radars_.learned, radars_.azimuth_signs,
                   radars_.range_rate_errors, radars_.range_rate_offsets, radars_.monitor);
  answer.resets = claims_.reset_counter.resets();
  answer.quality.live_point_count = static_cast<int>(live_.submap.point_count());
  answer.quality.beta = learner_.CheckBeta(radars_.learned.IndexOf(scan.radar_id));
  if (!tracking_.has_pose()) {
    answer.covariance = kUnknownVariance * Matrix6d::Identity();
    if (const std::optional<PoseEstimate<3>>& prior = relocalizer_.prior()) {
      answer.T_map_vehicle = prior->pose;
      answer.covariance = prior->covariance;
    }
    answer.state = tracking_.Report(HorizontalSigma(answer.covariance));
    return answer;
  }
  answer.T_map_vehicle = NowInMap().pose;
  answer.covariance =
      ToSpace<Dim>({.pose = {}, .covariance = pose_.NoiseCovarianceNow()}, options_.unobserved)
          .covariance;
  Claim(answer);
  answer.observed = map_.observability.ObservedDof(/*in_space=*/Dim == 3);
  return answer;
}

// By how much the motions that are probable differ.
template <int Dim>
double Pipeline<Dim>::AlongTrackSpread_m() const {
  const double spread_m = ego_motion_.along_track_spread_m();
  if (ego_motion_.sources().IsRuledOut(OdometrySource::kDoppler)) return spread_m;
  return spread_m + radars_.range_rate_errors.disputed_distance_m();
}

// METHOD eq 57. A stamp that is off by a time is a position that is off along-track.
template <int Dim>
double Pipeline<Dim>::ClaimedPositionSigma(const Matrix6d& covariance, double speed_mps) const {
  return std::hypot(HorizontalSigma(covariance), speed_mps * radars_.stamp_error.undecided_step_s,
                    AlongTrackSpread_m());
}

// The stamp's own variance comes last: the level holds it by its bound, METHOD eq 56.
template <int Dim>
void Pipeline<Dim>::Claim(Localization& answer) const {
  const EgoVelocity velocity = ego_motion_.velocity().value_or(EgoVelocity{});
  const double speed_mps = velocity.linear_mps.norm();
  answer.state = tracking_.Report(
      ClaimedPositionSigma(answer.covariance, speed_mps),
      std::hypot(std::sqrt(answer.covariance(5, 5)), ego_motion_.turn_spread_rad()));
  if (answer.state == LocalizationState::kTracking) {
    const double along_track_m = speed_mps * radars_.stamp_error.bound_s +
                                 speed_mps * radars_.stamp_error.undecided_step_s +
                                 AlongTrackSpread_m() + ego_motion_.undecided_distance_m() +
                                 radars_.range_biases.suspected_m();
    answer.protection_level_m = claims_.protection_level.Of(answer.covariance, along_track_m);
  }
  Vector6d per_second;
  per_second << velocity.linear_mps, velocity.angular_radps;
  answer.covariance +=
      std::pow(radars_.stamp_error.sigma_s, 2) * per_second * per_second.transpose();
}

template <int Dim>
PoseEstimate<Dim> Pipeline<Dim>::PoseThen(const MotionHistory::Moment& moment) const {
  const PoseEstimate<Dim> now = pose_.Now();
  const Pose3 T_newest_then = moment.to_newest.T_from_to.Inverse();
  return {.pose = now.pose * FromSpace<Dim>(T_newest_then, Matrix6d::Zero()).pose,
          .covariance = now.covariance};
}

template <int Dim>
std::optional<AnyPipeline::TriedFit> Pipeline<Dim>::TryFit(const Scan& scan, Stamp stamp,
                                                           LocalizerWorkspace& lent_workspace) {
  const std::optional<MotionHistory::Moment> moment = ego_motion_.history().AtOrSoonAfter(stamp);
  if (!moment || !tracking_.has_pose()) return std::nullopt;
  Workspace<Dim>& workspace = lent_workspace.Of<Dim>();
  const std::size_t radar_index = radars_.learned.IndexOf(scan.radar_id);
  const Scan& measured = AsMeasured(Corrected(scan, workspace), moment->velocity, workspace);
  StaticPoints(measured, radars_.learned.rig().radars[radar_index], moment->velocity,
               EffectiveStaticPoints(options_), workspace.tried_points);
  const double fit = radars_.scan_checker.FitAt(workspace.tried_points, PoseThen(*moment),
                                                map_.matcher, workspace);
  return TriedFit{fit, radars_.scan_checker.Judge(radar_index, workspace.scan_points.size(), fit)};
}

template Localization Pipeline<2>::FinishScan(const Scan&, Stamp);
template Localization Pipeline<3>::FinishScan(const Scan&, Stamp);
template Localization Pipeline<2>::LocalizeUntimed(const Scan&, Stamp, std::chrono::nanoseconds);
template Localization Pipeline<3>::LocalizeUntimed(const Scan&, Stamp, std::chrono::nanoseconds);
template void Pipeline<2>::ExpireTimeouts(Stamp);
template void Pipeline<3>::ExpireTimeouts(Stamp);
template Localization Pipeline<2>::Answer(const Scan&, Stamp) const;
template Localization Pipeline<3>::Answer(const Scan&, Stamp) const;
template void Pipeline<2>::Claim(Localization&) const;
template void Pipeline<3>::Claim(Localization&) const;
template PoseEstimate<2> Pipeline<2>::PoseThen(const MotionHistory::Moment&) const;
template PoseEstimate<3> Pipeline<3>::PoseThen(const MotionHistory::Moment&) const;
template std::optional<AnyPipeline::TriedFit> Pipeline<2>::TryFit(const Scan&, Stamp,
                                                                  LocalizerWorkspace&);
template std::optional<AnyPipeline::TriedFit> Pipeline<3>::TryFit(const Scan&, Stamp,
                                                                  LocalizerWorkspace&);

}  // namespace dcloc
