#pragma once

#include <vector>

#include "client/simulation/radar/echoes.h"
#include "core/radar/scan.h"

namespace dcloc::simulation {

struct ScanSimulatorOptions {
  RadarProfile profile;
  double clutter_share = 0.04;       ///< of a scan's targets, on average
  double ghost_share = 0.04;         ///< of a scan's targets, if the scene has as many
  double range_rate_step_mps = 0.0;  ///< quantisation of range rates; 0 for none
  bool is_flat = false;              ///< measured as if all stood at the radar's height
};

/// A scan with, row by row, the exact echo behind each target. Targets are ordered by their range.
struct SimulatedScan {
  Scan scan;
  std::vector<Echo> echoes;
};

/// One scan of `radar`: collect echoes, merge what it cannot resolve, miss some, keep as many as it
/// can list, add ghosts and clutter, and measure (with the coupling `radar.beta_s`). The caller
/// sets stamp, radar id and ego-velocity.
SimulatedScan SimulateScan(const Scene& scene, const std::vector<MovingBody>& bodies,
                           const MotionState& motion, const RadarModel& radar,
                           const ScanSimulatorOptions& options, Random& random);

/// Appends the measurement of `echo` by `radar` as a row to `scan`: the coupling, the profile's
/// noise, quantisation, then aliasing. False when no valid range is left.
bool AppendMeasurement(const Echo& echo, const RadarModel& radar,
                       const ScanSimulatorOptions& options, Random& random, Scan& scan);

}  // namespace dcloc::simulation
