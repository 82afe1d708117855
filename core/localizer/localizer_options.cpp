#include "core/localizer/localizer_options.h"

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

// One number of the options and where it must lie.
struct Bound {
  const char* field;
  double value;
  double min;
  double max;
};

double Milliseconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace

absl::Status Validate(const LocalizerOptions& options) {
  constexpr double kTiny = 1e-6;  // where zero would be an infinite weight
  constexpr double kMaxPoints = 100'000;
  constexpr double kMaxTime_ms = 1e6;
  const StaticPointsOptions& points = options.static_points;
  const MatchOptions& match = options.match;
  const OdometryErrorFilterOptions& errors = options.odometry_error_filter;
  const Bound bounds[] = {
      {"scans_per_submap", 1.0 * options.scans_per_submap, 1, 100},
      {"registration_interval_ms", Milliseconds(options.registration_interval), 0, 10'000},
      {"tracking_scans", 1.0 * options.tracking_scans, 1, 100},
      {"static_points.min_range_m", points.min_range_m, 0, 1000},
      {"static_points.max_range_m", points.max_range_m, points.min_range_m, 1000},
      {"static_points.static_gate_mps", points.static_gate_mps, 0, 100},
      {"static_points.static_gate_sigmas", points.static_gate_sigmas, 0, 100},
      {"odometry_error_filter.scale_sigma", errors.scale_sigma, 0, 0.5},
      {"odometry_error_filter.yaw_rate_bias_sigma_radps", errors.yaw_rate_bias_sigma_radps, 0, 1},
      {"odometry_error_filter.course_sigma_rad", errors.course_sigma_rad, 0, 1},
      {"odometry_error_filter.time_offset_sigma_s", errors.time_offset_sigma_s, 0, 10},
      {"odometry_error_filter.min_scale_sigma", errors.min_scale_sigma, 0, 0.5},
      {"odometry_error_filter.pose_sigma_m", errors.pose_sigma_m, kTiny, 100},
      {"odometry_error_filter.pose_sigma_rad", errors.pose_sigma_rad, kTiny, 1},
      {"odometry.acceleration_sigma_mps2", options.odometry.acceleration_sigma_mps2, 0, 100},
      {"odometry.yaw_acceleration_sigma_radps2", options.odometry.yaw_acceleration_sigma_radps2, 0,
       100},
      {"match.max_prior_sigma_m", options.match.max_prior_sigma_m, 0, 100},
      {"match.max_prior_sigma_rad", options.match.max_prior_sigma_rad, 0, 10},
      {"state.tracking_sigma_m", options.state.tracking_sigma_m, 0, 1000},
      {"state.lost_hold_ms", Milliseconds(options.state.lost_hold), 1, 1e6},
      {"state.contradiction_span_ms", Milliseconds(options.state.contradiction_span), 0, 1e6},
      {"odometry.correlation_time_ms", Milliseconds(options.odometry.correlation_time), 1,
       kMaxTime_ms},
      {"gicp.max_iterations", 1.0 * options.gicp.max_iterations, 1, 1000},
      {"gicp.reach_m", options.gicp.reach_m, 0.1, 20},
      {"gicp.gate_sigmas", options.gicp.gate_sigmas, kTiny, 1000},
      {"gicp.huber_sigmas", options.gicp.huber_sigmas, kTiny, 1000},
      {"match.local_map_radius_m", match.local_map_radius_m, 10, 1000},
      {"match.max_live_points", 1.0 * match.max_live_points, 10, kMaxPoints},
      {"match.min_inlier_count", 1.0 * match.min_inlier_count, 1, kMaxPoints},
      {"match.min_overlap", match.min_overlap, 0, 1},
      {"match.max_residual_scale", match.max_residual_scale, kTiny, 1000},
      {"match.hypotheses", 1.0 * match.hypotheses, 0, 1000},
      {"match.wide_sigma_m", match.wide_sigma_m, 0, 100},
      {"match.wide_hypotheses", 1.0 * match.wide_hypotheses, 0, 1000},
      {"match.wide_min_overlap", match.wide_min_overlap, 0, 1},
      {"match.wide_min_lead", match.wide_min_lead, 0, 1000},
      {"match.global_min_distance_m", match.global_min_distance_m, 0, 1000},
      {"match.global_min_lead", match.global_min_lead, 0, 1000},
      {"match.global_candidate_count", 1.0 * match.global_candidate_count, 1, 10'000},
      {"match.shared_sigma_m", match.shared_sigma_m, 0, 100},
      {"match.shared_sigma_rad", match.shared_sigma_rad, 0, 1},
      {"match.shared_time_ms", Milliseconds(match.shared_time), 0, kMaxTime_ms},
      {"pose_graph.window", 1.0 * options.pose_graph.window, 1, 1000},
      {"pose_graph.takeover_support", 1.0 * options.pose_graph.takeover_support, 2, 1'000'000},
      {"state.confirmations", 1.0 * options.state.confirmations, 1, 1000},
      {"state.global_start_max_refusals", 1.0 * options.state.global_start_max_refusals, 1, 1000},
      {"state.tracking_hold_ms", Milliseconds(options.state.tracking_hold), 0, kMaxTime_ms},
      {"state.lost_after_ms", Milliseconds(options.state.lost_after),
       Milliseconds(options.state.tracking_hold), kMaxTime_ms},
      {"state.lost_sigma_m", options.state.lost_sigma_m, kTiny, 1000},
      {"unobserved_z_sigma_m", options.unobserved_z_sigma_m, kTiny, 1000},
      {"unobserved_tilt_sigma_rad", options.unobserved_tilt_sigma_rad, kTiny, 1},
  };
  for (const Bound& bound : bounds) {
    // Written so that NaN fails.
    if (bound.value >= bound.min && bound.value <= bound.max) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s is %g; it must lie in [%g, %g]", bound.field, bound.value, bound.min, bound.max));
  }
  return absl::OkStatus();
}

}  // namespace dcloc
