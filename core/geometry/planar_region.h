#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "absl/status/status.h"

namespace dcloc {

/// A polygon in the xy plane. Its rings may be holes, holes' islands and so on: a point is within
/// it if an odd number of rings is around it. Rings close by themselves; the first vertex may be
/// repeated at the end.
struct PlanarPolygon {
  std::vector<std::vector<Eigen::Vector2d>> rings_m;
};

/// The union of polygons.
struct PlanarRegion {
  std::vector<PlanarPolygon> polygons;
};

/// The rectangle between two corners.
PlanarPolygon BoxPolygon(const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m);

/// Whether a polygon of the region holds `p_m`. Of two polygons that share a border, exactly one
/// holds a point on it. For many points see `RegionTest`.
bool Contains(const PlanarRegion& region, const Eigen::Vector2d& p_m);

/// Tests many points as `Contains` tests one: a ring whose bounding box does not hold the
/// point is not walked round. The region outlives this.
class RegionTest {
 public:
  explicit RegionTest(const PlanarRegion& region);

  bool Holds(const Eigen::Vector2d& p_m) const;

 private:
  struct BoxedRing {
    const std::vector<Eigen::Vector2d>* ring_m;
    Eigen::AlignedBox2d box_m;
  };
  std::vector<std::vector<BoxedRing>> polygons_;
};

/// InvalidArgument that names the polygon and ring, the value and the bound: a region has a
/// polygon, a polygon a ring, a ring three vertices and an area; coordinates are finite and within
/// 1e9 m.
absl::Status Validate(const PlanarRegion& region);

}  // namespace dcloc
