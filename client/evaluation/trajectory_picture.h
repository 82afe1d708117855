#pragma once

#include <optional>
#include <vector>

#include "client/evaluation/gnuplot.h"
#include "client/trajectory/trajectory.h"

namespace dcloc {

/// The tracks of at least one trajectory in the map's plane. With a reference also their errors in
/// position and heading over time, from the reference's first stamp.
Picture DrawTrajectories(const std::vector<Trajectory>& trajectories,
                         const std::optional<Trajectory>& reference);

}  // namespace dcloc
