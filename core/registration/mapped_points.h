#pragma once

#include <cstddef>
#include <span>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose.h"
#include "core/map/local_map.h"

namespace dcloc {

/// How many of the points (vehicle frame) lie where the map has landmarks, seen from
/// `T_local_vehicle`: within `reach_m` of one. Of the others the map says nothing: it may end
/// before them.
template <int Dim>
std::size_t CountMappedPoints(std::span<const GaussianPoint<Dim>> points, const LocalMap<Dim>& map,
                              const Pose<Dim>& T_local_vehicle, double reach_m);

}  // namespace dcloc
