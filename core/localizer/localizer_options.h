#pragma once

#include <chrono>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/pose_estimate.h"
#include "core/localizer/fix_monitor.h"
#include "core/localizer/knowledge_report.h"
#include "core/localizer/radar_clocks.h"
#include "core/localizer/radar_monitor.h"
#include "core/localizer/registration_schedule.h"
#include "core/localizer/reset_counter.h"
#include "core/localizer/stamp_monitor.h"
#include "core/localizer/time_base.h"
#include "core/localizer/tracking_state_machine.h"
#include "core/odometry/ego_motion.h"
#include "core/odometry/rig_knowledge.h"
#include "core/online_calibration/learned_rig.h"
#include "core/online_calibration/range_rate_errors.h"
#include "core/online_calibration/range_rate_offsets.h"
#include "core/options/option_fields.h"
#include "core/posegraph/pose_graph.h"
#include "core/radar/static_points.h"
#include "core/registration/map_matcher.h"
#include "core/relocalization/global_localizer.h"
#include "core/relocalization/pose_prior.h"
#include "core/submap/submap.h"
#include "core/uncertainty/along_track_rivals.h"
#include "core/uncertainty/azimuth_signs.h"
#include "core/uncertainty/beta_monitor.h"
#include "core/uncertainty/map_fit_monitor.h"
#include "core/uncertainty/noise_scale_estimator.h"
#include "core/uncertainty/place_evidence.h"
#include "core/uncertainty/protection_level.h"
#include "core/uncertainty/range_biases.h"
#include "core/uncertainty/registration_factor.h"

namespace dcloc {

/// Every choice in one vehicle's pipeline, a part for each stage. The defaults are what is
/// evaluated and recommended.
struct LocalizerOptions {
  /// The paper's three switches (Table II); the third is the pose graph's outlier gating. They own
  /// `static_points.compensate`, `static_points.per_point_covariance` and
  /// `pose_graph.gate_outliers`, which `Validate` refuses to be switched off beside them.
  bool doppler_compensation = true;
  bool per_point_covariance = true;
  bool gate_outliers = true;

  int scans_per_submap = 10;     ///< per radar, [1, 100]
  int max_submap_points = 1500;  ///< a fuller sub-map is thinned evenly to this before registration
  /// If the motion between two scans is less certain than this, the sub-map is emptied. Otherwise
  /// all scans from before it would be off by the same error, and outvote the new ones.
  double max_gap_sigma_m = 0.5;
  double max_gap_sigma_rad = 0.05;
  /// Where the spread of the sources of odometry adds more to a motion than this, what was learned
  /// of their noise says nothing of it.
  double usual_spread_m = 0.05;
  /// Deviations that are added to the covariance of an estimate that is given up as contradicted,
  /// before it becomes the prior of the search.
  double contradicted_sigma_m = 4.0;
  double contradicted_sigma_rad = 0.15;

  /// How long a vehicle moved while its clock was set.
  double clock_set_sigma_s = 0.3;
  /// Where searches find nothing, ranges are supposed to be as described, or as learned. The next
  /// time after so long, then after twice as long.
  std::chrono::nanoseconds range_trial = std::chrono::seconds(1);
  /// For so long a guess of them is tried.
  std::chrono::nanoseconds range_guess = std::chrono::seconds(3);
  /// What an earlier session of the same vehicle learned. Learning begins with it.
  RigKnowledge known;
  KnowledgeReportOptions knowledge_report;

  /// A pose from a prior is held against other places before it is called tracking.
  bool verify_prior = true;

  StampMonitorOptions stamp_monitor;
  RadarClocksOptions radar_clocks;
  TimeBaseOptions time_base;
  SubmapOptions submap;
  MapFitOptions map_fit;
  AlongTrackRivalOptions along_track_rivals;
  AzimuthSignOptions azimuth_signs;
  RangeBiasOptions range_biases;
  RangeRateErrorOptions range_rate_errors;
  RangeRateOffsetOptions range_rate_offsets;
  EgoMotionOptions ego_motion;
  LearnedRigOptions learned_rig;
  RadarMonitorOptions radar_monitor;
  StaticPointsOptions static_points;
  RegistrationScheduleOptions schedule;
  MapMatcherOptions matcher;
  PosePriorOptions prior;
  GlobalLocalizerOptions global;
  NoiseScaleOptions noise_scales;
  BetaMonitorOptions beta_monitor;
  RegistrationFactorOptions factor;
  PoseGraphOptions pose_graph;
  TrackingOptions tracking;
  FixMonitorOptions fixes;
  ResetOptions resets;
  PlaceEvidenceOptions place_evidence;
  ProtectionLevelOptions protection_level;

  UnobservedSigmas unobserved;  ///< of planar rigs
};
std::span<const OptionField<LocalizerOptions>> FieldsOf(const LocalizerOptions& options);

/// OK, or InvalidArgument that names the field of whatever stage, the value and the bound.
absl::Status Validate(const LocalizerOptions& options);

/// The options of two stages as the paper's switches set them.
StaticPointsOptions EffectiveStaticPoints(const LocalizerOptions& options);
PoseGraphOptions EffectivePoseGraph(const LocalizerOptions& options);

/// What a contradicted pose varies by besides its covariance, along each axis of the tangent space.
Vector6d ContradictedVariances(const LocalizerOptions& options);

}  // namespace dcloc
