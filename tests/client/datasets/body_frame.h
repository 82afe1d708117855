#pragma once

#include <vector>

#include "client/datasets/drive.h"
#include "client/simulation/simulation.h"

namespace dcloc {

/// Two passes through a simulated street, by one radar that measures elevation.
struct TwoPasses {
  Drive map;
  Drive live;
};

inline TwoPasses SimulateTwoPasses(std::uint64_t seed) {
  SimulationOptions options;
  options.length_m = 200.0;
  options.beta_s = 0.0;
  options.has_elevation = true;
  options.seed = seed;
  const std::vector<PassOptions> passes = Passes(options);
  return {SimulatePass(options, passes[0]).value(), SimulatePass(options, passes[1]).value()};
}

/// The body on which the drive's radar sits at `T_body_radar`, in the drive's vehicle frame.
inline Pose3 BodyOnVehicle(const Drive& drive, const Pose3& T_body_radar) {
  return drive.rig.radars[0].T_vehicle_radar * T_body_radar.Inverse();
}

}  // namespace dcloc
