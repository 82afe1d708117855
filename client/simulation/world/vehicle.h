#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "client/simulation/world/random.h"
#include "client/simulation/world/scatterer.h"
#include "core/geometry/pose.h"

namespace dcloc::simulation {

/// Another road user: a box on the ground with its scatterers.
/// Body frame: origin at the box's centre on the ground, x forward, y left, z up.
struct Vehicle {
  double length_m = 0.0;
  double width_m = 0.0;
  double height_m = 0.0;
  std::vector<Scatterer> scatterers;  ///< positions and directions in the body frame
};

/// A car, a van or (by `truck_share`) a truck, with its own pattern of scatterers.
Vehicle MakeVehicle(Random& random, double truck_share);

/// The four sides of the vehicle, in the map.
std::array<Wall, 4> Outline(const Vehicle& vehicle, const Pose2& T_map_body);

}  // namespace dcloc::simulation
