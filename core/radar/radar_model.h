#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/degrees.h"
#include "core/geometry/pose.h"
#include "core/radar/scan.h"

namespace dcloc {

/// One radar of a vehicle: where it sits, what it measures and how well.
struct RadarModel {
  std::string id;
  Pose3 T_vehicle_radar;

  /// Range-Doppler coupling: `measured range = range + beta_s * range_rate` (METHOD eq 5). Positive
  /// for an up-chirp, negative for a down-chirp, 0 if the firmware compensates already.
  double beta_s = 0.0;
  double range_bias_m = 0.0;   ///< `measured range = range + range_bias_m`
  double time_offset_s = 0.0;  ///< a scan was measured this long after its stamp

  /// Deviations of the errors that remain in beta_s, range_bias_m, time_offset_s and in the mount's
  /// yaw. The defaults are for a vehicle that was built to its drawing and never calibrated.
  double beta_sigma_s = 0.003;
  double range_bias_sigma_m = 0.1;
  double time_offset_sigma_s = 0.02;
  double mount_yaw_sigma_rad = 0.5 * kRadPerDeg;

  double range_sigma_m = 0.15;
  double range_rate_sigma_mps = 0.15;
  double azimuth_sigma_rad = kRadPerDeg;
  /// Where the radar measures no elevation: the spread of true elevations about the xy plane.
  double elevation_sigma_rad = 4.0 * kRadPerDeg;
  bool has_elevation = false;

  /// Range rates are known modulo twice this; 0 when the radar resolves the ambiguity itself.
  double unambiguous_range_rate_mps = 0.0;
};

inline constexpr std::size_t kMaxRadars = 64;
/// Stamps of radars are known where no time_offset_sigma_s is larger. Rigs that were never
/// calibrated have 0.02.
inline constexpr double kKnownTimeOffsetSigma_s = 0.018;

/// The radars of one vehicle, at most kMaxRadars; ids are unique.
struct Rig {
  std::vector<RadarModel> radars;

  /// The radar of that id, or nullptr.
  const RadarModel* Find(std::string_view id) const;

  /// Of a radar of the rig.
  std::size_t IndexOf(std::string_view id) const {
    return static_cast<std::size_t>(Find(id) - radars.data());
  }

  /// True when every radar measures elevation, so that all six degrees of freedom are observable.
  bool MeasuresElevation() const;

  /// True when it is known of every radar how late it stamps its scans, as a calibration or a drive
  /// finds it: to within kKnownTimeOffsetSigma_s, and not to the last digit.
  bool HasKnownStamps() const;
};

/// OK, or InvalidArgument that names the radar, the field, the value and the bound.
absl::Status Validate(const RadarModel& radar);
absl::Status Validate(const Rig& rig);

/// OK, or InvalidArgument that names what is wrong with the scan, or that it is of no radar of
/// `rig`.
absl::Status Validate(const Scan& scan, const Rig& rig);

/// beta_s of a chirp that sweeps `slope_hz_per_s` around `centre_frequency_hz` (METHOD eq 5).
double BetaFromChirp(double centre_frequency_hz, double slope_hz_per_s);

}  // namespace dcloc
