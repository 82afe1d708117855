#include "core/geometry/planar_region.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

constexpr double kMaxRegionCoordinate_m = 1e9;
constexpr double kBoxMargin_m = 1e-5;  // more than rounding moves the crossing of an edge

// Whether the ray from `p` along +x crosses an odd number of edges. Edges hold their lower end and
// not their upper one, so that a ray through a vertex crosses once.
bool IsAround(std::span<const Eigen::Vector2d> ring_m, const Eigen::Vector2d& p) {
  bool is_around = false;
  for (std::size_t i = 0; i < ring_m.size(); ++i) {
    // The lower end first, so that two polygons compute the same for an edge that they share.
    Eigen::Vector2d a = ring_m[i];
    Eigen::Vector2d b = ring_m[(i + 1) % ring_m.size()];
    if (a.y() > b.y()) std::swap(a, b);
    if (p.y() < a.y() || p.y() >= b.y()) continue;
    const Eigen::Vector2d edge = b - a;
    if (p.x() < a.x() + (p.y() - a.y()) / edge.y() * edge.x()) is_around = !is_around;
  }
  return is_around;
}

double Area_m2(std::span<const Eigen::Vector2d> ring_m) {
  double twice_m2 = 0.0;
  for (std::size_t i = 0; i < ring_m.size(); ++i) {
    // From the first vertex, so that far from the origin no digits are lost.
    const Eigen::Vector2d a = ring_m[i] - ring_m[0];
    const Eigen::Vector2d b = ring_m[(i + 1) % ring_m.size()] - ring_m[0];
    twice_m2 += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice_m2) / 2.0;
}

absl::Status CheckRing(std::span<const Eigen::Vector2d> ring_m) {
  if (ring_m.size() < 3) {
    return absl::InvalidArgumentError(
        absl::StrFormat("has %d vertices; it must have at least 3", ring_m.size()));
  }
  for (const Eigen::Vector2d& vertex_m : ring_m) {
    for (const double value : {vertex_m.x(), vertex_m.y()}) {
      if (std::abs(value) <= kMaxRegionCoordinate_m) continue;  // NaN is not
      return absl::InvalidArgumentError(
          absl::StrFormat("a coordinate is %g m; it must lie in [%g, %g]", value,
                          -kMaxRegionCoordinate_m, kMaxRegionCoordinate_m));
    }
  }
  if (const double area_m2 = Area_m2(ring_m); !(area_m2 > 0.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("has an area of %g m^2; it must be larger than 0", area_m2));
  }
  return absl::OkStatus();
}

}  // namespace

PlanarPolygon BoxPolygon(const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m) {
  return {.rings_m = {{min_m, {max_m.x(), min_m.y()}, max_m, {min_m.x(), max_m.y()}}}};
}

bool Contains(const PlanarRegion& region, const Eigen::Vector2d& p_m) {
  return RegionTest(region).Holds(p_m);
}

RegionTest::RegionTest(const PlanarRegion& region) {
  for (const PlanarPolygon& polygon : region.polygons) {
    std::vector<BoxedRing>& rings = polygons_.emplace_back();
    for (const auto& ring_m : polygon.rings_m) {
      Eigen::AlignedBox2d box_m;
      for (const Eigen::Vector2d& vertex_m : ring_m) box_m.extend(vertex_m);
      rings.push_back(
          {&ring_m, {box_m.min().array() - kBoxMargin_m, box_m.max().array() + kBoxMargin_m}});
    }
  }
}

bool RegionTest::Holds(const Eigen::Vector2d& p_m) const {
  return std::ranges::any_of(polygons_, [&](const std::vector<BoxedRing>& rings) {
    const auto count = std::ranges::count_if(rings, [&](const BoxedRing& ring) {
      return ring.box_m.contains(p_m) && IsAround(*ring.ring_m, p_m);
    });
    return count % 2 == 1;
  });
}

absl::Status Validate(const PlanarRegion& region) {
  if (region.polygons.empty()) return absl::InvalidArgumentError("the region has no polygon");
  for (std::size_t i = 0; i < region.polygons.size(); ++i) {
    const auto& rings_m = region.polygons[i].rings_m;
    if (rings_m.empty()) {
      return absl::InvalidArgumentError(absl::StrFormat("polygon %d has no ring", i));
    }
    for (std::size_t k = 0; k < rings_m.size(); ++k) {
      const absl::Status status = CheckRing(rings_m[k]);
      if (status.ok()) continue;
      return absl::InvalidArgumentError(
          absl::StrFormat("polygon %d: ring %d %s", i, k, status.message()));
    }
  }
  return absl::OkStatus();
}

}  // namespace dcloc
