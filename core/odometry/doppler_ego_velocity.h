#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// A scan with the radar that took it.
struct RadarScan {
  const Scan* scan = nullptr;
  const RadarModel* radar = nullptr;
  /// By how much faster the vehicle is at the moment of all scans than when this one was taken.
  double speed_gain_mps = 0.0;
};

struct EgoVelocityOptions {
  int ransac_iterations = 60;
  double inlier_gate_mps = 0.3;
  int min_inlier_count = 6;
  double min_inlier_fraction = 0.3;
  /// Side slip at the vehicle frame's origin: with a single radar it is what makes the yaw rate
  /// observable (METHOD 2: omega = V_y / l).
  double side_slip_sigma_mps = 0.05;
  /// Standing still: this fraction of the targets has a range rate within `zero_gate_mps`.
  double zero_fraction = 0.6;
  double zero_gate_mps = 0.15;
  /// The normal matrix's largest over its smallest eigenvalue, beyond which the targets' directions
  /// do not determine the state.
  double max_condition = 1e6;
  /// Targets within ten degrees of one another have together at most this fraction of all votes:
  /// one mover that fills a part of the view does not outvote the rest.
  double max_direction_fraction = 1.0 / 24.0;
  // Floors of the estimate's deviations: what calibration errors leave however many targets. Mounts
  // and delays err by a share of the speed.
  double crawling_sigma_floor_mps = 0.15;     ///< linear, of a vehicle that hardly moves
  double linear_sigma_floor_fraction = 0.05;  ///< more by this share of the speed
  double linear_sigma_floor_mps = 0.5;        ///< up to this; and of one that stands
  double yaw_rate_sigma_floor_radps = 0.03;
  double min_alternative_fraction = 0.15;  ///< of all votes, that an alternative motion needs
  /// Directions that an alternative motion must be seen in: more than one mover fills.
  int min_alternative_direction_count = 6;
};
std::span<const OptionField<EgoVelocityOptions>> FieldsOf(const EgoVelocityOptions& options);
absl::Status Validate(const EgoVelocityOptions& options);

/// What the Doppler measurements of one moment say about the vehicle's motion.
struct DopplerEgoVelocity {
  EgoVelocity ego_velocity;  ///< planar: v_z, roll rate and pitch rate are 0; covariance is set
  int inlier_count = 0;
  int target_count = 0;
  // In how many tens of degrees around the vehicle there are:
  int direction_count = 0;           ///< inliers
  int moving_direction_count = 0;    ///< inliers that a standing vehicle would not see
  int standing_direction_count = 0;  ///< others, that a standing vehicle would see
};

/// One target's row of the motion's equations: range rate = row . (v_x, v_y, yaw rate) + noise
/// (METHOD 2).
struct RangeRateRow {
  Eigen::Vector3d row;
  double range_rate_mps;
  double unambiguous_mps;
  double sigma_mps;
  /// Deviation of the azimuth. It turns the row, which changes the range rate by this times the
  /// velocity across the line of sight.
  double cross_row_sigma_rad;
  int direction = 0;  ///< which ten degrees around the vehicle the target lies in, [0, 36)
  double vote = 1.0;  ///< what it counts for, less where many lie in one direction
};

/// What EstimateEgoVelocity needs only while it runs.
struct EgoVelocityWorkspace {
  std::vector<RangeRateRow> rows;
  std::vector<RangeRateRow> inliers;
};

/// Planar ego-velocity (v_x, v_y, yaw rate) from the range rates of one or several scans of the
/// same moment: RANSAC on pairs of targets, weighted least squares on the inliers, covariance
/// max(1, s^2) (H^T W H)^-1 and a floor (METHOD eq 22, Kellner 2013). Aliased range rates are
/// unfolded to each hypothesis. Nothing when too few targets agree or their directions do not
/// determine the motion. The same scans and `seed` give the same answer, whatever `workspace` held.
std::optional<DopplerEgoVelocity> EstimateEgoVelocity(std::span<const RadarScan> scans,
                                                      std::uint64_t seed,
                                                      const EgoVelocityOptions& options,
                                                      EgoVelocityWorkspace& workspace);

/// The same with memory of its own.
std::optional<DopplerEgoVelocity> EstimateEgoVelocity(std::span<const RadarScan> scans,
                                                      std::uint64_t seed,
                                                      const EgoVelocityOptions& options = {});

/// The motion that the targets agree on which contradict `first`, the estimate that `workspace` was
/// last used for, from the same `seed`. A convoy around the vehicle and the ground behind it are
/// each other's alternatives. Nothing where too few targets agree, or in too few directions.
std::optional<DopplerEgoVelocity> EstimateAlternativeEgoVelocity(const DopplerEgoVelocity& first,
                                                                 std::uint64_t seed,
                                                                 const EgoVelocityOptions& options,
                                                                 EgoVelocityWorkspace& workspace);

/// Information-weighted mean of two independent estimates that both have a covariance.
EgoVelocity Fuse(const EgoVelocity& a, const EgoVelocity& b);

}  // namespace dcloc
