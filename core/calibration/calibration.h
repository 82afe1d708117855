#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "core/radar/radar_model.h"

namespace dcloc {

/// Possible errors in the description of one radar, in this order in every vector. The last two are
/// not properties of the radar, but would otherwise be taken for a range bias or for beta.
/// Scatterers above or below a planar radar are seen too far by h^2 / 2r. If farther scatterers are
/// higher, or if azimuths scatter, the error grows in proportion to the range (METHOD 4).
enum class CalibrationParameter {
  kBeta,
  kTimeOffset,
  kRangeBias,
  kMountYaw,
  kHeightSquare,
  kRangeScale
};
inline constexpr int kCalibrationParameters = 6;
/// [s, s, m, rad, m^2, 1]
using CalibrationVector = std::array<double, kCalibrationParameters>;

/// "beta_s", "time_offset_s", "range_bias_m", "mount_yaw_rad", "height_square_m2",
/// "range_scale".
const char* NameOf(CalibrationParameter parameter);

/// One correction with its uncertainty.
struct CalibratedParameter {
  double correction = 0.0;  ///< estimated correction, to be added to the description
  double sigma = 0.0;       ///< of the correction, at most `prior_sigma`
  double prior_sigma = 0.0;
  /// What is added to the description: all of the correction, or the part of it that the data
  /// support (`ChooseApplied`).
  double applied = 0.0;
  double remaining_sigma = 0.0;  ///< of the error that remains, at most `prior_sigma`

  /// The data reduced its deviation to less than half of the prior's.
  bool determined() const { return sigma < 0.5 * prior_sigma; }
  /// Determined, and 0 lies outside of the 95 % interval.
  bool significant() const;
};

/// One radar after calibration.
struct RadarCalibration {
  RadarModel described;
  std::array<CalibratedParameter, kCalibrationParameters> parameters;

  const CalibratedParameter& of(CalibrationParameter parameter) const {
    return parameters.at(static_cast<std::size_t>(parameter));
  }
};

/// Two parameters that are strongly correlated: the data determine their sum or difference better
/// than each.
struct Confusion {
  std::string radar;
  CalibrationParameter parameter;
  std::string other_radar;
  CalibrationParameter other_parameter;
  double correlation;  ///< beyond +-0.9
};

struct Calibration {
  std::vector<RadarCalibration> radars;  ///< in the rig's order
  /// Covariance of all corrections, kCalibrationParameters for each radar, in their units.
  Eigen::MatrixXd covariance;
  std::size_t return_count = 0;
  std::size_t pair_count = 0;

  /// The pairs, among the determined parameters, that the data cannot tell apart.
  std::vector<Confusion> Confusions() const;
};

/// The described radar with `parameter` corrected by `correction`; a parameter that is no property
/// of the radar changes nothing.
RadarModel Corrected(const RadarModel& described, CalibrationParameter parameter,
                     double correction);

/// The radar with the applied corrections, and with the deviations of the errors that remain.
RadarModel Calibrated(const RadarCalibration& radar);

}  // namespace dcloc
