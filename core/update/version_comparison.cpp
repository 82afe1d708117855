#include "core/update/version_comparison.h"

#include "core/map/point_grid.h"

namespace dcloc {
namespace {

PointGrid GridOf(const std::vector<PlacedLandmark>& landmarks) {
  PointGrid grid(1.0);
  for (const PlacedLandmark& landmark : landmarks) grid.Insert(landmark.position.position_m);
  return grid;
}

bool HasNear(const std::vector<PlacedLandmark>& landmarks, const PointGrid& grid,
             const Eigen::Vector2d& p_m, double reach_m) {
  bool has_near = false;
  grid.ForEachNear(p_m, Eigen::Vector2d::Constant(reach_m), [&](std::uint32_t i) {
    has_near = has_near || (landmarks[i].position.position_m - p_m).norm() <= reach_m;
  });
  return has_near;
}

}  // namespace

VersionComparison CompareVersions(const EditableMap& old_version, const EditableMap& new_version,
                                  double same_m) {
  const std::vector<PlacedLandmark> before = LandmarksOf(old_version);
  const std::vector<PlacedLandmark> after = LandmarksOf(new_version);
  const PointGrid before_grid = GridOf(before);
  const PointGrid after_grid = GridOf(after);
  VersionComparison comparison;
  for (const PlacedLandmark& landmark : before) {
    const bool is_common = HasNear(after, after_grid, landmark.position.position_m, same_m);
    (is_common ? comparison.common : comparison.removed).push_back(landmark);
  }
  for (const PlacedLandmark& landmark : after) {
    if (HasNear(before, before_grid, landmark.position.position_m, same_m)) continue;
    comparison.added.push_back(landmark);
  }
  return comparison;
}

}  // namespace dcloc
