#include "core/localizer/localizer_options.h"

#include "absl/strings/str_cat.h"

namespace dcloc {
namespace {

// A stage's switch that one of the localizer's own sets.
absl::Status ValidateOwned(const char* field, bool is_on, const char* owner) {
  if (is_on) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is false; set ", owner, " to false instead, which owns it"));
}

}  // namespace

std::span<const OptionField<LocalizerOptions>> FieldsOf(const LocalizerOptions& /*options*/) {
  using O = LocalizerOptions;
  static constexpr OptionField<O> kFields[] = {
      {"scans_per_submap", &O::scans_per_submap, 1, 100},
      {"max_submap_points", &O::max_submap_points, 10, 100'000},
      {"max_gap_sigma_m", &O::max_gap_sigma_m, 1e-6, 1000},
      {"max_gap_sigma_rad", &O::max_gap_sigma_rad, 1e-6, 10},
      {"usual_spread_m", &O::usual_spread_m, 0, 1000, "any spread is beyond what was learned"},
      {"contradicted_sigma_m", &O::contradicted_sigma_m, 0, 1000, "its covariance holds"},
      {"contradicted_sigma_rad", &O::contradicted_sigma_rad, 0, 10, "its covariance holds"},
      {"clock_set_sigma_s", &O::clock_set_sigma_s, 0, 1000, "the odometry's covariance holds"},
      {"range_trial_ms", &O::range_trial, 1, 1e6},
      {"range_guess_ms", &O::range_guess, 1, 1e6},
  };
  return kFields;
}

absl::Status Validate(const LocalizerOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(ValidateOwned("static_points.compensate", options.static_points.compensate,
                              "doppler_compensation"));
  status.Update(ValidateOwned("static_points.per_point_covariance",
                              options.static_points.per_point_covariance, "per_point_covariance"));
  status.Update(
      ValidateOwned("pose_graph.gate_outliers", options.pose_graph.gate_outliers, "gate_outliers"));
  status.Update(Within("stamp_monitor", Validate(options.stamp_monitor)));
  status.Update(Within("radar_clocks", Validate(options.radar_clocks)));
  status.Update(Within("time_base", Validate(options.time_base)));
  status.Update(Within("submap", Validate(options.submap)));
  status.Update(Within("map_fit", Validate(options.map_fit)));
  status.Update(Within("along_track_rivals", Validate(options.along_track_rivals)));
  status.Update(Within("azimuth_signs", Validate(options.azimuth_signs)));
  status.Update(Within("range_biases", Validate(options.range_biases)));
  status.Update(Within("range_rate_errors", Validate(options.range_rate_errors)));
  status.Update(Within("range_rate_offsets", Validate(options.range_rate_offsets)));
  status.Update(Within("ego_motion", Validate(options.ego_motion)));
  status.Update(Within("learned_rig", Validate(options.learned_rig)));
  status.Update(Within("known", Validate(options.known)));
  status.Update(Within("knowledge_report", Validate(options.knowledge_report)));
  status.Update(Within("radar_monitor", Validate(options.radar_monitor)));
  status.Update(Within("static_points", Validate(options.static_points)));
  status.Update(Within("schedule", Validate(options.schedule)));
  status.Update(Within("matcher", Validate(options.matcher)));
  status.Update(Within("prior", Validate(options.prior)));
  status.Update(Within("global", Validate(options.global)));
  status.Update(Within("noise_scales", Validate(options.noise_scales)));
  status.Update(Within("beta_monitor", Validate(options.beta_monitor)));
  status.Update(Within("factor", Validate(options.factor)));
  status.Update(Within("pose_graph", Validate(options.pose_graph)));
  status.Update(Within("tracking", Validate(options.tracking)));
  status.Update(Within("fixes", Validate(options.fixes)));
  status.Update(Within("resets", Validate(options.resets)));
  status.Update(Within("place_evidence", Validate(options.place_evidence)));
  status.Update(Within("protection_level", Validate(options.protection_level)));
  status.Update(Within("unobserved", Validate(options.unobserved)));
  return status;
}

StaticPointsOptions EffectiveStaticPoints(const LocalizerOptions& options) {
  StaticPointsOptions points = options.static_points;
  points.compensate = options.doppler_compensation;
  points.per_point_covariance = options.per_point_covariance;
  return points;
}

PoseGraphOptions EffectivePoseGraph(const LocalizerOptions& options) {
  PoseGraphOptions graph = options.pose_graph;
  graph.gate_outliers = options.gate_outliers;
  return graph;
}

Vector6d ContradictedVariances(const LocalizerOptions& options) {
  Vector6d sigmas = Vector6d::Zero();
  sigmas.head<2>().setConstant(options.contradicted_sigma_m);
  sigmas(5) = options.contradicted_sigma_rad;
  return sigmas.cwiseAbs2();
}

}  // namespace dcloc
