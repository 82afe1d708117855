#include "core/update/map_replay.h"

#include <algorithm>
#include <chrono>

#include "core/odometry/ego_motion.h"

namespace dcloc {
namespace {

constexpr std::chrono::nanoseconds kReach = std::chrono::seconds(2);

/// The way of the vehicle by odometry alone, in a frame that begins with it.
std::vector<Pose2> Way(const Rig& rig, std::span<const Scan> scans) {
  std::vector<Pose2> way;
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
    way.push_back(Flatten(T_start_vehicle));
  }
  return way;
}

double Middle(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Of poses that lie within metres and some degrees of one another.
Pose2 Middle(std::span<const Pose2> poses) {
  std::vector<double> x, y, yaw;
  for (const Pose2& pose : poses) {
    x.push_back(pose.translation_m.x());
    y.push_back(pose.translation_m.y());
    yaw.push_back(WrapAngle(pose.yaw_rad - poses.front().yaw_rad));
  }
  return {{Middle(x), Middle(y)}, WrapAngle(poses.front().yaw_rad + Middle(yaw))};
}

}  // namespace

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

std::vector<std::optional<Pose2>> ConsensusOf(std::span<const ReplayedScan> replay, const Rig& rig,
                                              std::span<const Scan> scans) {
  const std::vector<Pose2> way = Way(rig, scans);
  std::vector<std::optional<Pose2>> consensus(scans.size());
  std::size_t begin = 0;
  std::vector<Pose2> arrived;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    while (scans[begin].stamp < scans[i].stamp - kReach) ++begin;
    arrived.clear();
    for (std::size_t k = begin; k < scans.size() && scans[k].stamp <= scans[i].stamp + kReach;
         ++k) {
      if (!replay[k].is_tracking) continue;
      arrived.push_back(replay[k].T_map_vehicle * (way[k].Inverse() * way[i]));
    }
    if (!arrived.empty()) consensus[i] = Middle(arrived);
  }
  return consensus;
}

}  // namespace dcloc
