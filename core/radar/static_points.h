#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// One static target, in a frame that its user names.
struct RadarPoint {
  Eigen::Vector3d position_m;
  Eigen::Matrix3d covariance_m2;
  float rcs_dbsm = 0.0F;
  /// A planar radar measures the slant range r + h^2 / 2r to a scatterer at the ground range r and
  /// the height h over the radar. So the position is off by h^2 times this vector: the unit line of
  /// sight divided by 2r, in x and y. Zero for radars that measure elevation.
  Eigen::Vector2d slant_per_m = Eigen::Vector2d::Zero();
};

struct StaticPointsOptions {
  /// Doppler compensation `r - beta v_r` (METHOD eq 6); off only for ablation.
  bool compensate = true;
  /// Per-target covariances (METHOD eq 9-11); off gives every point the same isotropic one.
  bool per_point_covariance = true;
  double min_range_m = 1.5;  ///< nearer targets are the vehicle's own body
  double max_range_m = 100.0;
  /// Gate on the innovation of the range rate, its difference from what the ego-motion predicts. A
  /// target is static within `static_gate_mps` plus `static_gate_sigmas` deviations of the
  /// prediction.
  double static_gate_mps = 0.3;
  double static_gate_sigmas = 3.0;
};
std::span<const OptionField<StaticPointsOptions>> FieldsOf(const StaticPointsOptions& options);
absl::Status Validate(const StaticPointsOptions& options);

/// Compensates a scan and keeps its static targets, in the **vehicle frame** at its stamp, with
/// covariances. Aliased range rates are unfolded to the value nearest to what the ego-motion
/// predicts (METHOD 1). Targets outside the gate around the prediction move, and are left out
/// (METHOD 2). `scan` and `radar` are valid (`Validate`) and belong together.
std::vector<RadarPoint> StaticPoints(const Scan& scan, const RadarModel& radar,
                                     const EgoVelocity& ego_velocity,
                                     const StaticPointsOptions& options);

/// The same, into `points`, whose former contents are replaced; its memory is reused.
void StaticPoints(const Scan& scan, const RadarModel& radar, const EgoVelocity& ego_velocity,
                  const StaticPointsOptions& options, std::vector<RadarPoint>& points);

/// Where the radar was when it measured, in the vehicle frame of the scan's stamp.
Pose3 MountAtStamp(const RadarModel& radar, const EgoVelocity& ego_velocity);

}  // namespace dcloc
