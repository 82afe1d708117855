#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/map/editable_map.h"
#include "core/map/point_grid.h"
#include "core/passes/placed_landmark.h"

namespace dcloc {

/// Places in the plane.
class PlaceSet {
 public:
  explicit PlaceSet(std::vector<Eigen::Vector2d> places_m);

  /// Whether one lies within `reach_m` of `p_m`.
  bool HasNear(const Eigen::Vector2d& p_m, double reach_m) const;

 private:
  std::vector<Eigen::Vector2d> places_m_;
  PointGrid grid_{1.0};
};

/// The landmarks of two versions of a map, by what became of them.
struct VersionComparison {
  std::vector<PlacedLandmark> common;        ///< of the old version, which the new one has too
  std::vector<PlacedLandmark> removed;       ///< of the old version alone
  std::vector<PlacedLandmark> added;         ///< of the new version alone
  std::vector<PlacedLandmark> intermittent;  ///< of the old version alone, where things come and go
};

/// A landmark of one version is in the other one too if that has a landmark within `same_m`: a
/// refined landmark is the same. The versions share a frame and a local origin, relative to which
/// `intermittent` are the places where things come and go.
VersionComparison CompareVersions(const EditableMap& old_version, const EditableMap& new_version,
                                  double same_m, const PlaceSet& intermittent);

}  // namespace dcloc
