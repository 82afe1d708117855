#pragma once

#include <memory>

#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"

namespace dcloc {

/// A short simulated street, driven twice at different speeds.
struct SimulatedDrives {
  Drive map_drive;
  Drive live_drive;
};

inline SimulatedDrives SimulateDrives(double beta_s = 0.0) {
  SimulationOptions options;
  options.length_m = 200.0;
  options.beta_s = beta_s;
  const std::vector<PassOptions> passes = Passes(options);
  return {SimulatePass(options, passes[0]).value(), SimulatePass(options, passes[1]).value()};
}

inline std::shared_ptr<const RadarMap> MapOf(const Drive& drive, MapBuilderOptions options = {}) {
  options.name = drive.name;
  return RadarMap::FromBytes(BuildMap(drive, options).value()).value();
}

}  // namespace dcloc
