// What position fixes do to the pose.
#include "core/geometry/pose_estimate.h"
#include "core/localizer/pipeline.h"

namespace dcloc {

template <int Dim>
FixUse Pipeline<Dim>::TakeFix(const InitialPose& fix, Stamp stamp) {
  std::optional<PoseEstimate<3>> pose;
  if (tracking_.has_pose()) pose = NowInMap();
  const std::optional<PoseEstimate<3>> now = CarriedToNow(
      {fix.T_map_vehicle, fix.covariance}, stamp, pose, ego_motion_.history(), options_.fixes);
  if (!now) return FixUse::kOutOfTime;
  if (!pose) {
    relocalizer_.OnFix(*now);
    return FixUse::kGuidesSearch;
  }
  switch (fix_monitor_.Classify(stamp, *now, *pose)) {
    case FixVerdict::kAgrees:
      tracking_.OnFixAgrees();
      return FixUse::kConsistentNotFused;
    case FixVerdict::kFusable:
      return FuseFix(*now);
    case FixVerdict::kContradictsPersistently:
      tracking_.OnFixesContradict();
      relocalizer_.SetPrior(*now);
      return FixUse::kContradicted;
    case FixVerdict::kContradicts:
      return FixUse::kContradicted;
  }
  return FixUse::kContradicted;
}

// The graph's gate is narrower than the monitor's: a fix between the two neither moves the pose nor
// makes it doubted.
template <int Dim>
FixUse Pipeline<Dim>::FuseFix(const PoseEstimate<3>& T_map_vehicle) {
  const PoseEstimate<3> position = PositionOf(T_map_vehicle);
  pose_.AddState();
  const InnovationTest test = pose_.AddPosition(
      FromSpace<Dim>(map_.matcher.T_map_local().Inverse() * position.pose, position.covariance));
  if (!test.is_accepted) return FixUse::kContradicted;
  fix_monitor_.OnFused();
  tracking_.OnFixAgrees();
  return FixUse::kFused;
}

template FixUse Pipeline<2>::TakeFix(const InitialPose&, Stamp);
template FixUse Pipeline<3>::TakeFix(const InitialPose&, Stamp);
template FixUse Pipeline<2>::FuseFix(const PoseEstimate<3>&);
template FixUse Pipeline<3>::FuseFix(const PoseEstimate<3>&);

}  // namespace dcloc
