#include "core/relocalization/global_localizer_options.h"

namespace dcloc {

std::span<const OptionField<GlobalLocalizerOptions>> FieldsOf(
    const GlobalLocalizerOptions& /*options*/) {
  using O = GlobalLocalizerOptions;
  static constexpr OptionField<O> kFields[] = {
      {"view_overlap_share", &O::view_overlap_share, 0, 1, "any overlap is enough in a view"},
      {"convincing_overlap", &O::convincing_overlap, 0, 1, "any acceptable place convinces"},
      {"convincing_score_sigmas", &O::convincing_score_sigmas, 0, 1e6,
       "a place must score as usual"},
      {"min_usual_score_sigma", &O::min_usual_score_sigma, 1e-6, 1},
      {"min_usual_score_count", &O::min_usual_score_count, 2, 1'000'000},
      {"score_forgetting_factor", &O::score_forgetting_factor, 0, 0.999'999,
       "the newest score alone counts"},
      {"min_distance_m", &O::min_distance_m, 0, 1000, "two views are enough"},
      {"min_lead", &O::min_lead, 0, 1000, "the best one needs no lead"},
      {"prior_lead", &O::prior_lead, 0, 1000, "a prior must fit best"},
      {"min_view_span_ms", &O::min_view_span, 0, 1e6, "one scan is a view"},
      {"view_interval_ms", &O::view_interval, 0, 1e6, "the distance alone decides"},
      {"view_distance_m", &O::view_distance_m, 0, 1000, "a standing vehicle takes views too"},
      {"early_view_count", &O::early_view_count, 0, 1000, "views are rare from the start"},
      {"late_view_interval_factor", &O::late_view_interval_factor, 1, 1000},
      {"entering_view_interval_factor", &O::entering_view_interval_factor, 1, 1000},
      {"max_view_count", &O::max_view_count, 2, 100},
      {"max_view_sigma_m", &O::max_view_sigma_m, 1e-6, 100},
      {"max_view_sigma_rad", &O::max_view_sigma_rad, 1e-6, 10},
      {"candidate_count", &O::candidate_count, 1, 10'000},
      {"max_kept_candidates", &O::max_kept_candidates, 1, 10'000},
      {"fine_point_count", &O::fine_point_count, 10, 100'000},
      {"coarse_point_count", &O::coarse_point_count, 10, 100'000},
      {"cell_m", &O::cell_m, 0.1, 10},
      {"small_region_cell_m", &O::small_region_cell_m, 0.1, 10},
      {"small_region_radius_m", &O::small_region_radius_m, 0, 1000, "no region is small"},
      {"log_likelihood_per_score", &O::log_likelihood_per_score, 1e-6, 1e6},
      {"coarse_score_margin", &O::coarse_score_margin, 0, 1, "only the best one is kept"},
      {"new_candidate_margin", &O::new_candidate_margin, 0, 1000, "only the best one is kept"},
      {"candidate_margin", &O::candidate_margin, 0, 1000, "only the best one is kept"},
      {"same_place_m", &O::same_place_m, 1e-6, 100},
      {"same_place_rad", &O::same_place_rad, 1e-6, 4},
      {"registration_sigma_m", &O::registration_sigma_m, 1e-6, 100},
      {"registration_sigma_rad", &O::registration_sigma_rad, 1e-6, 4},
      {"max_work", &O::max_work, 1, 1e12},
  };
  return kFields;
}

absl::Status Validate(const GlobalLocalizerOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("gate", Validate(options.gate)));
  status.Update(Within("expected_gate", Validate(options.expected_gate)));
  return status;
}

}  // namespace dcloc
