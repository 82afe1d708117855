#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/simulation/radar/noise.h"
#include "client/simulation/radar/radar_profile.h"
#include "client/simulation/world/ageing.h"
#include "client/simulation/world/world.h"

namespace dcloc {

using simulation::NoiseKind;
using simulation::RadarKind;
using simulation::WorldKind;

inline constexpr double kMpsPerKmh = 1.0 / 3.6;

/// A world, a rig, and the drives through it. Equal options give equal bytes.
struct SimulationOptions {
  WorldKind world = WorldKind::kTown;
  RadarKind radar = RadarKind::kArs408;
  NoiseKind noise = NoiseKind::kGaussian;  ///< others (Table IV) only for `kCarla`
  int rig_size = 1;                        ///< 1 (front) or 5
  std::uint64_t seed = 1;
  double length_m = 1000.0;  ///< of each drive
  double tunnel_m = 0.0;  ///< of a tunnel without features in the middle of the drive; 0 for none

  /// A lap of the town's street, which then is a ring: drives begin at different places of it. 0
  /// for a street with two ends.
  double loop_m = 0.0;
  bool both_ways = false;  ///< on the ring, every second drive goes the other way round

  double map_speed_mps = 72.0 / 3.6;                   ///< mean of the map pass
  std::vector<double> live_speeds_mps = {40.0 / 3.6};  ///< means of the live passes
  bool stops = false;                                  ///< halt at about every other crossroads
  double signal_rate_hz = 50.0;                        ///< of wheels and gyroscope on the bus
  double scan_rate_hz = 0.0;                           ///< of each radar; 0: as its kind does

  double noise_scale = 1.0;  ///< of all measurement noise; the rig's described sigmas do not change
  bool is_flat = false;      ///< ranges and range rates as if all stood at the radar's height
  double beta_s = 0.04;      ///< range-Doppler coupling of every radar
  bool has_elevation = false;
  double unambiguous_range_rate_mps = 0.0;  ///< 0: no aliasing
  double range_rate_step_mps = 0.0;         ///< 0: not quantised

  double parked_change_share = 0.2;  ///< of the parked vehicles, between map and live passes
  double clutter_share = 0.04;       ///< of a scan's targets
  double ghost_share = 0.04;         ///< likewise

  /// The day of the map pass; live passes follow, a day each. Another day has other drives, traffic
  /// and parked vehicles in the same world.
  int day = 0;
  /// Passes take vehicles in turn. All but the first have their radars elsewhere on the body, as
  /// their rigs say.
  int vehicle_count = 1;
  /// What has changed since the map pass, which sees the world as it was; live passes see it aged.
  simulation::AgeingOptions ageing;
};

/// InvalidArgument naming the field, its value and its bound; OK otherwise.
absl::Status Validate(const SimulationOptions& options);

/// One drive through the world.
struct PassOptions {
  std::string name = "map";
  int index = 0;  ///< 0 is the map pass; others differ in traffic, lane and parked vehicles
  double mean_speed_mps = 20.0;
  double begin_m = 0.0;      ///< from where drives begin; other than 0 only on a ring
  bool is_reversed = false;  ///< goes the other way; only on a ring
};

/// What a pass draws its random numbers by: other on every day, and never that of a pass of day 0.
inline int DrawOf(int day, int pass_index) {
  constexpr int kPassesPerDay = 1000;  // more than a simulation may have
  return day * kPassesPerDay + pass_index;
}

/// InvalidArgument naming the field, its value and its bound; OK otherwise.
absl::Status Validate(const PassOptions& pass);

/// "map", then "live-0", "live-1", ... in the order of `live_speeds_mps`.
std::vector<PassOptions> Passes(const SimulationOptions& options);

}  // namespace dcloc
