// What was learned, and what another pipeline of the same vehicle goes on from.
#include "core/geometry/pose_estimate.h"
#include "core/localizer/localizer_snapshot.h"
#include "core/localizer/pipeline.h"

namespace dcloc {
namespace {

// Which of them is wrong is known after moments only, and would have to be found again.
bool IsSetAside(const SourceHealth& source) {
  return !source.is_used && source.fault != SourceFault::kSilent;
}

}  // namespace

template <int Dim>
const RigKnowledge& Pipeline<Dim>::Knowledge() {
  claims_.known.radars.clear();
  ego_motion_.AddTo(claims_.known);
  radars_.learned.AddTo(claims_.known);
  const bool is_guess = radars_.range_biases.KnowsNothing();
  for (std::size_t i = 0; i < rig().radars.size(); ++i) {
    if (const auto& bias_m = radars_.range_biases.bias_m(i); bias_m && !is_guess) {
      claims_.known.Of(rig().radars[i].id).range_bias_error = bias_m;
    }
    const BetaCheck beta = learner_.CheckBeta(i);
    if (beta.sigma_s > options_.knowledge_report.max_beta_sigma_s) continue;
    claims_.known.Of(rig().radars[i].id).beta_error = {beta.error_s, beta.sigma_s * beta.sigma_s};
  }
  return claims_.known;
}

template <int Dim>
void Pipeline<Dim>::RestoreKnown(const RigKnowledge& known) {
  radars_.learned.Restore(known);
  ego_motion_.Restore(known);
  for (std::size_t i = 0; i < rig().radars.size(); ++i) {
    const RadarKnowledge* radar = known.Find(rig().radars[i].id);
    if (radar == nullptr || !radar->range_bias_error) continue;
    radars_.range_biases.Restore(i, *radar->range_bias_error);
    radars_.learned.CorrectRange(i, radars_.range_biases.bias_m(i));
  }
}

template <int Dim>
std::optional<LocalizerSnapshot> Pipeline<Dim>::Snapshot() {
  const std::optional<TrackingSnapshot> tracking = tracking_.Snapshot();
  const std::optional<EgoVelocity>& velocity = ego_motion_.velocity();
  if (!tracking || !velocity || !velocity->covariance) return std::nullopt;
  if (IsSetAside(ego_motion_.wheel_speed()) || IsSetAside(ego_motion_.yaw_rate())) {
    return std::nullopt;
  }
  // The hypotheses are not handed on: there must be no alternative among them.
  if (ego_motion_.along_track_spread_m() > options_.ego_motion.sources.min_alternative_distance_m) {
    return std::nullopt;
  }
  const PoseEstimate<3> now = NowInMap();
  return LocalizerSnapshot{.pose = {.T_map_vehicle = now.pose, .covariance = now.covariance},
                           .velocity = *velocity,
                           .tracking = *tracking,
                           .known = Knowledge(),
                           .noise = pose_.noise_scales().knowledge(),
                           .resets = claims_.reset_counter.resets(),
                           .mean_nis = claims_.protection_level.mean_nis(),
                           .contradiction_m = claims_.protection_level.contradiction_m(),
                           .registration_count = registration_count_,
                           .clocks_ahead = {}};
}

template <int Dim>
void Pipeline<Dim>::Restore(const LocalizerSnapshot& snapshot) {
  RestoreKnown(snapshot.known);
  ego_motion_.Restore(snapshot.stamp, snapshot.velocity);
  const Pose3& T_map_vehicle = snapshot.pose.T_map_vehicle;
  RegistrationWorkspace<Dim> workspace;
  map_.matcher.MoveTo(T_map_vehicle.translation_m, workspace);
  pose_.Restore(FromSpace<Dim>(map_.matcher.T_map_local().Inverse() * T_map_vehicle,
                               snapshot.pose.covariance),
                snapshot.noise);
  tracking_.Restore(snapshot.tracking);
  rivals_.SupposeThatItStandsOut();
  // The prior that came with the opening is of a later moment.
  relocalizer_.SetPrior({.pose = T_map_vehicle, .covariance = snapshot.pose.covariance});
  claims_.reset_counter.Restore(snapshot.resets, T_map_vehicle);
  claims_.protection_level.Restore(snapshot.mean_nis, snapshot.contradiction_m);
  registration_count_ = snapshot.registration_count;
}

template void Pipeline<2>::RestoreKnown(const RigKnowledge&);
template void Pipeline<3>::RestoreKnown(const RigKnowledge&);
template const RigKnowledge& Pipeline<2>::Knowledge();
template const RigKnowledge& Pipeline<3>::Knowledge();
template std::optional<LocalizerSnapshot> Pipeline<2>::Snapshot();
template std::optional<LocalizerSnapshot> Pipeline<3>::Snapshot();
template void Pipeline<2>::Restore(const LocalizerSnapshot&);
template void Pipeline<3>::Restore(const LocalizerSnapshot&);

}  // namespace dcloc
