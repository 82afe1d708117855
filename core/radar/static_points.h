#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// One static target, in a frame that the holder names.
struct RadarPoint {
  Eigen::Vector3d position_m;
  Eigen::Matrix3d covariance_m2;
  float rcs_dbsm = 0.0F;
  /// A planar radar measures the slant range r + h^2 / 2r to what stands at the ground range r and
  /// the height h over it. So the position is off by h^2 times this: the line of sight over 2r, in
  /// x and y. Zero of radars that measure elevation.
  Eigen::Vector2d slant_per_m = Eigen::Vector2d::Zero();
};

struct StaticPointsOptions {
  /// Doppler compensation `r - beta v_r` (METHOD eq 6); off only for ablation.
  bool compensate = true;
  /// Per-target covariances (METHOD eq 9-11); off gives every point the same isotropic one.
  bool uncertainty = true;
  double min_range_m = 1.5;  ///< nearer targets are the vehicle's own body
  double max_range_m = 100.0;
  /// A target is static when its range rate is this near to what the ego-motion predicts; on top
  /// of it, `static_gate_sigmas` of the prediction's own spread.
  double static_gate_mps = 0.3;
  double static_gate_sigmas = 3.0;
};
std::span<const OptionField<StaticPointsOptions>> FieldsOf(const StaticPointsOptions& options);
absl::Status Validate(const StaticPointsOptions& options);

/// The static targets of `scan`, compensated, in the **vehicle frame** at its stamp, with
/// covariances. Aliased range rates are unfolded to the one that the ego-motion predicts (METHOD
/// 1); what then disagrees with the prediction moves and is left out (METHOD 2). `scan` and `radar`
/// are valid (`Validate`) and belong together.
std::vector<RadarPoint> StaticPoints(const Scan& scan, const RadarModel& radar,
                                     const EgoVelocity& ego_velocity,
                                     const StaticPointsOptions& options);

/// The same in place of what `points` held; its memory is used again.
void StaticPoints(const Scan& scan, const RadarModel& radar, const EgoVelocity& ego_velocity,
                  const StaticPointsOptions& options, std::vector<RadarPoint>& points);

}  // namespace dcloc
