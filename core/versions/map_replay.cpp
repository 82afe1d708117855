#include "core/versions/map_replay.h"

#include <optional>
#include <utility>

#include "core/odometry/ego_motion.h"

namespace dcloc {

absl::StatusOr<std::vector<ReplayedScan>> ReplayPass(std::shared_ptr<const RadarMap> map,
                                                     const Rig& rig, std::span<const Scan> scans) {
  auto localizer = Localizer::Create(std::move(map), rig, std::nullopt);
  if (!localizer.ok()) return localizer.status();
  std::vector<ReplayedScan> replay;
  replay.reserve(scans.size());
  for (const Scan& scan : scans) {
    ReplayedScan& replayed = replay.emplace_back();
    const absl::StatusOr<Localization> answer = localizer->Localize(scan);
    if (!answer.ok()) continue;
    replayed.is_tracking = answer->state == LocalizationState::kTracking;
    replayed.T_map_vehicle = Flatten(answer->T_map_vehicle);
    constexpr int kAxes[] = {0, 1, 5};
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        replayed.covariance(row, column) = answer->covariance(kAxes[row], kAxes[column]);
      }
    }
  }
  return replay;
}

std::vector<Pose2> OdometryTrack(const Rig& rig, std::span<const Scan> scans) {
  std::vector<Pose2> track;
  EgoMotion ego_motion;
  Pose3 T_start_vehicle;
  Stamp newest{};
  for (const Scan& scan : scans) {
    const RadarModel* const radar = rig.Find(scan.radar_id);
    if (radar != nullptr && scan.stamp >= newest) {
      ego_motion.Advance(scan, *radar);
      T_start_vehicle = T_start_vehicle * ego_motion.since_previous().T_from_to;
      newest = scan.stamp;
    }
    track.push_back(Flatten(T_start_vehicle));
  }
  return track;
}

}  // namespace dcloc
