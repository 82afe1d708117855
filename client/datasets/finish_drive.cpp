#include "client/datasets/finish_drive.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

constexpr double kTiltStep_m = 1.0;
constexpr std::size_t kMinTiltCount = 20;

// Where no radar measures elevation, heights are not estimated.
void NoteTilt(Drive& drive) {
  constexpr double kUsualTilt_rad = 1.5 * kRadPerDeg;
  if (drive.pose_source == PoseSource::kNone ||
      std::ranges::none_of(drive.rig.radars, &RadarModel::has_elevation)) {
    return;
  }
  const std::optional<double> tilt_rad = TiltOfWay(drive);
  if (!tilt_rad || std::abs(*tilt_rad) < kUsualTilt_rad) return;
  drive.notes.push_back(absl::StrFormat(
      "the vehicle frame is tilted: by its poses it drives %.1f degrees out of its xy plane, so "
      "that heights drift between registrations; describe mounts and poses in a level frame",
      std::abs(*tilt_rad) * kDegPerRad));
}

}  // namespace

std::optional<double> TiltOfWay(const Drive& drive) {
  std::vector<double> tilts_rad;
  const Pose3* from = nullptr;
  for (const DriveScan& entry : drive.scans) {
    if (from == nullptr) from = &entry.T_map_vehicle;
    const Eigen::Vector3d way_m = (from->Inverse() * entry.T_map_vehicle).translation_m;
    if (way_m.norm() < kTiltStep_m) continue;
    // Backwards the same plane is left to the other side.
    const double up_m = std::copysign(way_m.z(), way_m.x() * way_m.z());
    tilts_rad.push_back(std::atan2(up_m, way_m.head<2>().norm()));
    from = &entry.T_map_vehicle;
  }
  if (tilts_rad.size() < kMinTiltCount) return std::nullopt;
  const auto middle = tilts_rad.begin() + static_cast<std::ptrdiff_t>(tilts_rad.size() / 2);
  std::ranges::nth_element(tilts_rad, middle);
  return *middle;
}

absl::Status FinishDrive(const DriveRequest& request, Drive& drive) {
  for (RadarModel& radar : drive.rig.radars) radar.beta_s = request.beta_s.value_or(radar.beta_s);
  if (absl::Status status = Validate(drive.rig); !status.ok()) return status;

  const auto key = [](const DriveScan& entry) {
    return std::tie(entry.scan.stamp, entry.scan.radar_id);
  };
  std::sort(drive.scans.begin(), drive.scans.end(),
            [&](const DriveScan& a, const DriveScan& b) { return key(a) < key(b); });
  const auto twice =
      std::adjacent_find(drive.scans.begin(), drive.scans.end(),
                         [&](const DriveScan& a, const DriveScan& b) { return key(a) == key(b); });
  if (twice != drive.scans.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat(twice->scan.radar_id, " has two scans of one stamp, ",
                     twice->scan.stamp.time_since_epoch().count(), " ns"));
  }
  for (const DriveScan& entry : drive.scans) {
    if (!entry.scan.ego_velocity.has_value()) continue;
    if (absl::Status status = Validate(*entry.scan.ego_velocity); !status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat("ego-velocity at ",
                                                     entry.scan.stamp.time_since_epoch().count(),
                                                     " ns: ", status.message()));
    }
  }
  NoteTilt(drive);
  return absl::OkStatus();
}

}  // namespace dcloc
