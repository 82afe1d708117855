#pragma once

#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/simulation/motion/ego_motion.h"
#include "client/simulation/radar/echoes.h"
#include "client/simulation/simulation_options.h"
#include "client/simulation/world/ageing.h"
#include "client/simulation/world/parking.h"
#include "client/simulation/world/world.h"

namespace dcloc {

/// What the vehicle's own bus says at one moment (`signal_rate_hz`), with the moment's true pose.
struct VehicleSignal {
  Stamp stamp;
  Pose3 T_map_vehicle;                                          ///< exact
  double speed_mps = 0.0;                                       ///< measured by the wheels
  double yaw_rate_radps = 0.0;                                  ///< measured by the gyroscope
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();  ///< exact, gravity included
};

/// What was really there at one scan.
struct ScanTruth {
  simulation::MotionState motion;
  std::vector<simulation::Echo> echoes;  ///< row by row, what each target comes from
};

/// A drive with everything that a simulator knows and a recording does not.
struct SimulatedPass {
  Drive drive;
  std::vector<ScanTruth> truth;  ///< one for each of `drive.scans`
  std::vector<VehicleSignal> signals;
  int vehicle = 0;                                ///< its number; vehicles have rigs of their own
  std::vector<simulation::ParkedVehicle> parked;  ///< at the kerb, for the whole drive
};

/// The world that `options` describe. `options` are valid.
simulation::World MakeWorld(const SimulationOptions& options);

/// That world as live passes see it: after `options.ageing`. The map pass sees it as it was.
simulation::AgedWorld AgeWorld(const simulation::World& world, const SimulationOptions& options);

/// Drives `pass` through `world` (made from the same options, and aged for live passes).
/// Scans carry an ego-velocity without covariance from wheels and gyroscope: a scale error (sigma
/// 0.5 %) and a gyro bias (sigma 0.0005 rad/s) drawn once a pass, noise of 0.02 m/s and 0.001
/// rad/s. Stamps are whole microseconds; poses, speeds and yaw rates are exact at them.
/// `progress`, where given, hears the share done after every scan.
/// InvalidArgument when `options` or `pass` are not valid.
absl::StatusOr<SimulatedPass> SimulatePassWithTruth(
    const simulation::World& world, const SimulationOptions& options, const PassOptions& pass,
    const std::function<void(double share)>& progress = {});

/// The drive alone, for evaluation; makes the world itself.
absl::StatusOr<Drive> SimulatePass(const SimulationOptions& options, const PassOptions& pass);

}  // namespace dcloc
