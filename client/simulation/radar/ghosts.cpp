#include "client/simulation/radar/ghosts.h"

#include <algorithm>
#include <cmath>

namespace dcloc::simulation {
namespace {

constexpr std::size_t kStrongEchoes = 30;
constexpr double kMirrorLossDb = 8.0;
constexpr double kMirrorReach = 60.0;  // farther walls mirror too little [m]
constexpr double kDoubleBounceLossDb = 14.0;
constexpr double kDoubleBounceReach = 25.0;  // [m]

std::vector<const Echo*> Strongest(const std::vector<Echo>& echoes) {
  std::vector<const Echo*> strongest;
  strongest.reserve(echoes.size());
  for (const Echo& echo : echoes) strongest.push_back(&echo);
  std::stable_sort(strongest.begin(), strongest.end(),
                   [](const Echo* a, const Echo* b) { return a->snr_db > b->snr_db; });
  strongest.resize(std::min(strongest.size(), kStrongEchoes));
  return strongest;
}

void KeepIfDetectable(Echo ghost, double loss_db, const RadarProfile& profile,
                      std::vector<Echo>& ghosts) {
  ghost.rcs_dbsm -= loss_db;
  ghost.snr_db = ghost.rcs_dbsm + BeamGainDb(profile, ghost.observation);
  if (ghost.snr_db > 0.0 && ghost.rcs_dbsm > profile.min_rcs_dbsm) ghosts.push_back(ghost);
}

void AddMirrorGhost(const Echo& echo, const Wall& wall, const Occlusion& occlusion,
                    const RadarView& view, const RadarProfile& profile, std::vector<Echo>& ghosts) {
  const Eigen::Vector2d side = (wall.end_m - wall.begin_m).normalized();
  const Eigen::Vector3d normal(-side.y(), side.x(), 0.0);
  Eigen::Vector3d foot;
  foot << wall.begin_m, 0.0;
  const auto mirror = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(v - 2.0 * normal.dot(v) * normal);
  };

  Echo ghost = echo;
  ghost.source = EchoSource::kMirror;
  ghost.p_map = foot + mirror(echo.p_map - foot);
  ghost.velocity_map_mps = mirror(echo.velocity_map_mps);
  const Eigen::Vector3d& eye = occlusion.viewpoint();
  const double share = CrossingShare(eye.head<2>(), ghost.p_map.head<2>(), wall);
  if (share < 0.0) return;
  // Target and radar must be on the same side; what stands before the wall spoils the bounce.
  if (normal.dot(echo.p_map - foot) * normal.dot(eye - foot) <= 0.0) return;
  const Eigen::Vector3d bounce = eye + share * (ghost.p_map - eye);
  if (bounce.z() > wall.height_m || occlusion.LossDb(bounce, 0.3) > 0.0) return;
  ghost.observation = view.Observe(ghost.p_map, ghost.velocity_map_mps);
  KeepIfDetectable(ghost, kMirrorLossDb, profile, ghosts);
}

void AddDoubleBounce(const Echo& echo, const RadarView& view, const RadarProfile& profile,
                     std::vector<Echo>& ghosts) {
  if (echo.source != EchoSource::kMoving || echo.observation.range_m > kDoubleBounceReach) return;
  Echo ghost = echo;
  ghost.source = EchoSource::kDoubleBounce;
  const Eigen::Vector3d sight = echo.p_map - view.T_map_radar.translation_m;
  ghost.p_map = echo.p_map + sight;
  ghost.observation.range_m *= 2.0;
  ghost.observation.range_rate_mps *= 2.0;
  KeepIfDetectable(ghost, kDoubleBounceLossDb, profile, ghosts);
}

}  // namespace

std::vector<Echo> CollectGhosts(const std::vector<Echo>& echoes, const Occlusion& occlusion,
                                const RadarView& view, const RadarProfile& profile) {
  std::vector<const Wall*> mirrors;
  const Eigen::Vector2d eye = occlusion.viewpoint().head<2>();
  for (const Wall& wall : occlusion.walls()) {
    const double distance = (0.5 * (wall.begin_m + wall.end_m) - eye).norm();
    if (wall.is_mirror && distance < kMirrorReach) mirrors.push_back(&wall);
  }
  std::vector<Echo> ghosts;
  for (const Echo* echo : Strongest(echoes)) {
    AddDoubleBounce(*echo, view, profile, ghosts);
    for (const Wall* wall : mirrors) {
      AddMirrorGhost(*echo, *wall, occlusion, view, profile, ghosts);
    }
  }
  return ghosts;
}

}  // namespace dcloc::simulation
