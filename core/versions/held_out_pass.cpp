#include "core/versions/held_out_pass.h"

#include <cstdint>

#include "core/map/point_grid.h"
#include "core/odometry/ego_motion.h"
#include "core/passes/pass_alignment.h"
#include "core/passes/pass_centers.h"

namespace dcloc {
namespace {

/// Where a map was driven.
class DrivenGround {
 public:
  explicit DrivenGround(std::span<const Eigen::Vector2d> keyframes_m) : keyframes_m_(keyframes_m) {
    for (const Eigen::Vector2d& p_m : keyframes_m) grid_.Insert(p_m);
  }

  bool Has(const Eigen::Vector2d& p_local_m) const {
    bool is_near = false;
    grid_.ForEachNear(p_local_m, Eigen::Vector2d::Constant(kReach_m), [&](std::uint32_t k) {
      is_near = is_near || (keyframes_m_[k] - p_local_m).norm() <= kReach_m;
    });
    return is_near;
  }

 private:
  static constexpr double kReach_m = BeyondMapOptions{}.reach_m;
  std::span<const Eigen::Vector2d> keyframes_m_;
  PointGrid grid_{kReach_m};
};

/// The scans that both versions track, where the old one puts them, and those beyond it that the
/// new one tracks.
HeldOutPass Tracked(const Rig& rig, std::span<const Scan> scans,
                    std::span<const ReplayedScan> old_replay,
                    std::span<const ReplayedScan> new_replay, const DrivenGround& old_ground,
                    const Eigen::Vector3d& origin_m) {
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
    if (!new_replay[i].is_tracking) continue;
    const bool is_beyond =
        !old_replay[i].is_tracking &&
        !old_ground.Has(new_replay[i].T_map_vehicle.translation_m - origin_m.head<2>());
    if (!old_replay[i].is_tracking && !is_beyond) continue;
    const ReplayedScan& placed = is_beyond ? new_replay[i] : old_replay[i];
    held_out.scans.push_back(i);
    held_out.pass.scans.push_back({.stamp = newest,
                                   .radar = rig.IndexOf(scans[i].radar_id),
                                   .T_map_vehicle = Embed(placed.T_map_vehicle),
                                   .T_start_vehicle = track[i],
                                   .is_good = true,
                                   .is_beyond_map = is_beyond,
                                   .points = StaticPoints(scans[i], *radar, velocity, {})});
  }
  return held_out;
}

PlacedPass Aligned(PlacedPass pass, std::span<const PlacedLandmark> landmarks,
                   const Eigen::Vector3d& origin_m) {
  AlignPass({PositionsOf(landmarks), {}}, origin_m, {}, pass);
  return pass;
}

}  // namespace

HeldOutPass PlaceInBoth(const Rig& rig, std::span<const Scan> scans,
                        std::span<const ReplayedScan> old_replay,
                        std::span<const ReplayedScan> new_replay,
                        std::span<const PlacedLandmark> old_landmarks,
                        std::span<const PlacedLandmark> new_landmarks,
                        std::span<const Eigen::Vector2d> old_keyframes_m,
                        const Eigen::Vector3d& origin_m) {
  HeldOutPass held_out =
      Tracked(rig, scans, old_replay, new_replay, DrivenGround(old_keyframes_m), origin_m);
  if (held_out.pass.GoodCount() == 0) return {};
  const PlacedPass in_old = Aligned(held_out.pass, old_landmarks, origin_m);
  const PlacedPass in_new = Aligned(held_out.pass, new_landmarks, origin_m);
  for (std::size_t i = 0; i < held_out.pass.scans.size(); ++i) {
    const Pose2 T_map_old = Flatten(in_old.scans[i].T_map_vehicle);
    const Pose2 T_old_new = T_map_old.Inverse() * Flatten(in_new.scans[i].T_map_vehicle);
    held_out.T_old_new.push_back(T_old_new);
    const double share = held_out.pass.scans[i].is_beyond_map ? 1.0 : 0.5;
    held_out.pass.scans[i].T_map_vehicle =
        Embed(T_map_old * Exp(Eigen::Vector3d(share * Log(T_old_new))));
  }
  return held_out;
}

}  // namespace dcloc
