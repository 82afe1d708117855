#pragma once

#include "client/simulation/world/world.h"

namespace dcloc::simulation {

/// Where the tunnel that belongs in the middle of the drive begins no more than `reach_m` after the
/// end of the route as it is laid so far: lays the route straight on to the tunnel's end, marks it
/// in `world`, and says true. Only once, and not at all without a tunnel (`tunnel_m` 0).
bool LayTunnelIfNear(World& world, double tunnel_m, double half_width_m, double reach_m);

/// Clears `world.tunnel`, if there is one, of all that stands in it, and builds its walls.
void BuildTunnel(World& world);

}  // namespace dcloc::simulation
