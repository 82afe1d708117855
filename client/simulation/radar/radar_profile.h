#pragma once

#include "client/simulation/radar/noise.h"
#include "core/radar/radar_model.h"

namespace dcloc::simulation {

enum class RadarKind { kArs408, kCarla };

/// How a kind of radar detects and measures; what `RadarModel` does not say.
struct RadarProfile {
  double period_s = 0.075;
  double max_range_m = 100.0;  ///< outside of the far beam
  double half_field_rad = 1.0;
  double far_max_range_m = 0.0;  ///< of the far beam; 0 without one
  double far_half_field_rad = 0.0;

  /// A target of 0 dBsm straight ahead reaches the detection threshold at this range.
  double reference_range_m = 60.0;
  double edge_loss_db = 12.0;             ///< two-way antenna loss at the edge of the field of view
  double far_gain_db = 0.0;               ///< two-way gain of the far beam on its axis
  double elevation_half_power_rad = 0.1;  ///< one-sided, two-way half power
  double min_rcs_dbsm = -5.0;             ///< weaker ones are not reported

  double range_resolution_m = 0.4;  ///< nearer targets merge, if also close in angle and range rate
  double azimuth_resolution_rad = 0.05;
  double range_rate_resolution_mps = 0.3;
  int min_targets = 125;  ///< the cap per scan is drawn from [min_targets, max_targets]
  int max_targets = 125;
  double miss_probability = 0.15;
  /// Which targets make it under the cap: 0 the strongest, large values any.
  double selection_noise_db = 6.0;

  Noise range_m;
  Noise azimuth_rad;
  Noise elevation_rad;
  Noise range_rate_mps;
  /// Angle noise grows by 1 / cos(azimuth), as an array's does, and all noise as targets get
  /// weaker.
  bool noise_depends_on_target = false;
};

/// A Continental-ARS408-like radar: 13.3 Hz, 60 degrees to either side to 100 m, 9 degrees to 250
/// m, 125 targets; ranges good to 0.15 m, azimuth to 1 degree on the axis, range rates to 0.1 m/s.
RadarProfile Ars408Profile();

/// The radar of the paper's CARLA experiment (section IV-B): 100 m, 150 degrees, 100 to 150 targets
/// of any strength, noise of Table IV alike for all targets. The table's Gamma angle is printed as
/// 0.025 degrees and taken so. CARLA's own radar samples surfaces by random rays; here it samples
/// the world's persistent scatterers, so that both radars see the same world.
RadarProfile CarlaProfile(NoiseKind kind);

/// A rig of 1 (front) or 5 radars with the nuScenes names and mounts: `RADAR_FRONT`,
/// `RADAR_FRONT_LEFT`, `RADAR_FRONT_RIGHT` (both look aside), `RADAR_BACK_LEFT`,
/// `RADAR_BACK_RIGHT`. Sigmas are the profile's standard deviations on the axis.
Rig MakeRig(const RadarProfile& profile, int radar_count, double beta_s, bool has_elevation,
            double unambiguous_range_rate_mps);

}  // namespace dcloc::simulation
