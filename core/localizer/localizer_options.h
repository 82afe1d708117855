#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "core/odometry/doppler_ego_velocity.h"
#include "core/odometry/motion.h"
#include "core/odometry/odometry_error_filter.h"
#include "core/posegraph/pose_graph.h"
#include "core/radar/static_points.h"
#include "core/registration/gicp.h"

namespace dcloc {

/// When a registration is believed, and what it is worth.
struct MatchOptions {
  double local_map_radius_m = 100.0;
  int max_live_points = 1500;  ///< of a fuller sub-map an even choice is matched
  int min_inlier_count = 10;
  double min_overlap = 0.2;
  double max_residual_scale = 1.8;
  /// Predictions less certain than this are searched around before refinement.
  double search_sigma_m = 0.4;
  double search_sigma_rad = 0.03;
  int hypotheses = 4;
  /// Predictions less certain than this may leave several places that look alike. More of them are
  /// tried, and the best is believed only with this overlap, when its log-posterior leads that of
  /// every other place by so much, and when none fits the scans better. With less overlap a place
  /// that was searched for must so stand out whatever the prediction.
  double wide_sigma_m = 1.8;
  int wide_hypotheses = 10;
  double wide_min_overlap = 0.3;
  double wide_min_lead = 2.5;
  /// Priors less certain than this are no prediction: the ground that they leave is searched like a
  /// whole map, in every heading that they leave.
  double max_prior_sigma_m = 3.5;
  double max_prior_sigma_rad = 0.2;
  /// Without a prior a place must fit better than around a prediction, hold over so much way, for
  /// who stands still always sees the same, and be more likely than every other one by this lead of
  /// its log-likelihood. So many places are tried for each view.
  int global_min_inlier_count = 200;
  double global_min_overlap = 0.6;
  double global_min_distance_m = 10.0;
  double global_min_lead = 4.5;
  int global_candidate_count = 60;
  /// What every registration lacks however many points agree: errors that its points share, of the
  /// map, of mounts and of clocks. They keep their value for `shared_time`, so that more
  /// registrations within it do not average them out.
  double shared_sigma_m = 0.08;
  double shared_sigma_rad = 0.003;
  std::chrono::nanoseconds shared_time = std::chrono::seconds(3);
};

/// When a state of the answer changes to another.
struct StateOptions {
  /// At the start and after a silence registration waits for this share of a full sub-map, or so
  /// long.
  double start_share = 0.8;
  std::chrono::nanoseconds start_span = std::chrono::milliseconds(1000);
  int confirmations = 3;  ///< believed registrations in a row that start tracking
  /// After a search without a prior, refused registrations in a row that start it anew.
  int global_start_max_refusals = 3;
  std::chrono::nanoseconds tracking_hold = std::chrono::milliseconds(400);
  double tracking_sigma_m = 1.0;  ///< poses less certain than this are not called tracking
  /// Without a believed registration for so long, or less certain than this, dead reckoning is
  /// lost. Radars that scan ten times a second so report it within a second of losing the map.
  std::chrono::nanoseconds lost_after = std::chrono::milliseconds(900);
  double lost_sigma_m = 2.0;
  /// Who is lost and so uncertain for so long is looked for as at a start without a prior, nearby
  /// first.
  std::chrono::nanoseconds lost_hold = std::chrono::milliseconds(1000);
  /// So is who within so long is lost twice to registrations that contradict the estimate.
  std::chrono::nanoseconds contradiction_span = std::chrono::seconds(10);
};

/// Every choice in one vehicle's pipeline. The defaults are what is evaluated and recommended.
struct LocalizerOptions {
  int scans_per_submap = 10;  ///< per radar, [1, 100]

  /// The paper's three switches (Table II).
  bool doppler_compensation = true;
  bool uncertainty = true;
  bool truncation = true;

  /// Radars of a rig that follow one another faster than this share a registration.
  std::chrono::nanoseconds registration_interval = std::chrono::milliseconds(40);
  /// While tracking, after a registration that was believed, the next one waits for so many new
  /// scans: the more of them two sub-maps have in common, the less the second one says.
  int tracking_scans = 2;

  EgoVelocityOptions ego_velocity;
  StaticPointsOptions static_points;
  OdometryOptions odometry;
  OdometryErrorFilterOptions odometry_error_filter;
  GicpOptions gicp;
  MatchOptions match;
  PoseGraphOptions pose_graph;
  StateOptions state;

  /// What a planar rig does not observe comes from the map's keyframes with these deviations.
  double unobserved_z_sigma_m = 0.5;
  double unobserved_tilt_sigma_rad = 0.03;
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const LocalizerOptions& options);

}  // namespace dcloc
