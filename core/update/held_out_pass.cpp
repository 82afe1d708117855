#include "core/update/held_out_pass.h"

#include "core/odometry/ego_motion.h"
#include "core/update/pass_alignment.h"
#include "core/update/pass_centers.h"

namespace dcloc {
namespace {

/// The scans that both versions track, where the old one puts them.
HeldOutPass TrackedInBoth(const Rig& rig, std::span<const Scan> scans,
                          std::span<const ReplayedScan> old_replay,
                          std::span<const ReplayedScan> new_replay) {
  HeldOutPass held_out;
  held_out.pass.rig = rig;
  const std::vector<Pose2> track = OdometryTrack(rig, scans);
  EgoMotion ego_motion;
  Stamp newest{};
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const RadarModel* const radar = rig.Find(scans[i].radar_id);
    if (radar == nullptr || scans[i].stamp < newest) continue;
    newest = scans[i].stamp;
    const EgoVelocity& velocity = ego_motion.Advance(scans[i], *radar);
    if (!old_replay[i].is_tracking || !new_replay[i].is_tracking) continue;
    held_out.scans.push_back(i);
    held_out.pass.scans.push_back({.stamp = newest,
                                   .radar = rig.IndexOf(scans[i].radar_id),
                                   .T_map_vehicle = Embed(old_replay[i].T_map_vehicle),
                                   .T_start_vehicle = track[i],
                                   .is_good = true,
                                   .points = StaticPoints(scans[i], *radar, velocity, {})});
  }
  return held_out;
}

PlacedPass Aligned(PlacedPass pass, std::span<const PlacedLandmark> landmarks,
                   const Eigen::Vector3d& origin_m) {
  std::vector<LandmarkPosition> positions;
  for (const PlacedLandmark& landmark : landmarks) positions.push_back(landmark.position);
  AlignPass(positions, origin_m, {}, pass);
  return pass;
}

}  // namespace

HeldOutPass PlaceInBoth(const Rig& rig, std::span<const Scan> scans,
                        std::span<const ReplayedScan> old_replay,
                        std::span<const ReplayedScan> new_replay,
                        std::span<const PlacedLandmark> old_landmarks,
                        std::span<const PlacedLandmark> new_landmarks,
                        const Eigen::Vector3d& origin_m) {
  HeldOutPass held_out = TrackedInBoth(rig, scans, old_replay, new_replay);
  const PlacedPass in_old = Aligned(held_out.pass, old_landmarks, origin_m);
  const PlacedPass in_new = Aligned(held_out.pass, new_landmarks, origin_m);
  for (std::size_t i = 0; i < held_out.pass.scans.size(); ++i) {
    const Pose2 T_map_old = Flatten(in_old.scans[i].T_map_vehicle);
    const Pose2 T_old_new = T_map_old.Inverse() * Flatten(in_new.scans[i].T_map_vehicle);
    held_out.T_old_new.push_back(T_old_new);
    held_out.pass.scans[i].T_map_vehicle =
        Embed(T_map_old * Exp(Eigen::Vector3d(0.5 * Log(T_old_new))));
  }
  return held_out;
}

}  // namespace dcloc
