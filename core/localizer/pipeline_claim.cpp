// What an answer claims of its pose, beyond the pose graph's covariance.
#include <cmath>

#include "core/geometry/covariance.h"
#include "core/localizer/pipeline.h"

namespace dcloc {

// A stamp that is off is an error along the way (METHOD eq 54).
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

// METHOD eq 50. What stands still lies in the map where the vehicle has really come to.
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

template void Pipeline<2>::CompareSourcesByMapFit(Workspace<2>& workspace);
template void Pipeline<3>::CompareSourcesByMapFit(Workspace<3>& workspace);
template void Pipeline<2>::Claim(Localization& answer);
template void Pipeline<3>::Claim(Localization& answer);
template std::optional<double> Pipeline<2>::FitAt(const Scan&, Stamp, LocalizerWorkspace&);
template std::optional<double> Pipeline<3>::FitAt(const Scan&, Stamp, LocalizerWorkspace&);

}  // namespace dcloc
