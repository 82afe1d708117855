#include "client/datasets/vehicle_tilt.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace dcloc {
namespace {

constexpr double kStep_m = 1.0;
constexpr std::size_t kMinStepCount = 20;

}  // namespace

std::optional<double> TiltOfWay(const Drive& drive) {
  std::vector<double> tilts_rad;
  const Pose3* from = nullptr;
  for (const DriveScan& entry : drive.scans) {
    if (from == nullptr) from = &entry.T_map_vehicle;
    const Eigen::Vector3d way_m = (from->Inverse() * entry.T_map_vehicle).translation_m;
    if (way_m.norm() < kStep_m) continue;
    // Backwards the same plane is left to the other side.
    const double up_m = std::copysign(way_m.z(), way_m.x() * way_m.z());
    tilts_rad.push_back(std::atan2(up_m, way_m.head<2>().norm()));
    from = &entry.T_map_vehicle;
  }
  if (tilts_rad.size() < kMinStepCount) return std::nullopt;
  const auto middle = tilts_rad.begin() + static_cast<std::ptrdiff_t>(tilts_rad.size() / 2);
  std::ranges::nth_element(tilts_rad, middle);
  return *middle;
}

}  // namespace dcloc
