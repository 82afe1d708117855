#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/evaluation/disturbance.h"
#include "client/simulation/simulation_options.h"
#include "core/map/radar_map.h"

namespace dcloc::robustness {

/// Drives of one place, and what is wrong with the live one as it is.
struct Course {
  Drive map;
  Drive live;
  std::vector<Episode> episodes;
};

/// A live drive through a world.
struct Pass {
  double speed_kmh;
  bool stops;
};

/// The map drive and a live drive called `name` through the world of `options`; when the live one
/// is between a tunnel's walls is an episode. InvalidArgument for invalid options.
absl::StatusOr<Course> SimulateCourse(const SimulationOptions& options, const Pass& pass,
                                      const std::string& name);

/// The map made of `drive`. Errors as of BuildMap.
absl::StatusOr<std::shared_ptr<const RadarMap>> MapOf(const Drive& drive);

}  // namespace dcloc::robustness
