#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/thinning.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// Up to `max_count` of a scan's points, evenly among them, in the dimension of a pipeline.
template <int Dim>
void ThinPoints(const std::vector<RadarPoint>& scan, int max_count,
                std::vector<GaussianPoint<Dim>>& points) {
  points.clear();
  TakeEvenly(scan, max_count, [&](const RadarPoint& point) {
    points.push_back({.mean_m = point.position_m.head<Dim>(),
                      .covariance_m2 = point.covariance_m2.topLeftCorner<Dim, Dim>()});
    if constexpr (Dim == 2) points.back().slant_per_m = point.slant_per_m;
  });
}

}  // namespace dcloc
