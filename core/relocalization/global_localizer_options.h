#pragma once

#include <chrono>
#include <span>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/registration/map_matcher.h"

namespace dcloc {

/// When views are taken, which places are candidates, and what the winner must reach.
struct GlobalLocalizerOptions {
  /// What a registration of the winner must reach.
  RegistrationGate gate = {.min_inlier_count = 200, .min_overlap = 0.6};
  /// In each view this share of the gate's overlap is enough: the first views may show ground from
  /// before the map's beginning.
  double view_overlap_share = 0.83;
  /// What is seen of a known place overlaps the map by more than this, of a wrong one by less. Only
  /// such an expected place is right before the whole map was searched.
  double convincing_overlap = 0.7;
  // And it scores as registrations did where the vehicle surely was: less by no more than this.
  double convincing_score_sigmas = 3.0;   ///< in standard deviations of those scores
  double min_usual_score_sigma = 0.02;    ///< which are no smaller
  int min_usual_score_count = 20;         ///< fewer tell nothing
  double score_forgetting_factor = 0.98;  ///< weight of an older one beside the next, [0, 1)
  /// What an expected place must reach in each view once the whole map was searched.
  RegistrationGate expected_gate = {};
  double min_distance_m = 10.0;  ///< travelled while it holds: standing still, all views agree
  double min_lead = 4.5;         ///< of its log-likelihood to that of every other place
  /// What a prior is given ahead of places that fit better, in log-likelihood, once there are
  /// `max_view_count` views.
  double prior_lead = 14.0;

  /// So long scans have come before the first view, at least.
  std::chrono::nanoseconds min_view_span = std::chrono::milliseconds(400);
  /// The time between two views, at least.
  std::chrono::nanoseconds view_interval = std::chrono::milliseconds(400);
  double view_distance_m = 4.0;  ///< travelled between two views, at least
  int early_view_count = 8;      ///< views after which, where nothing is found, they become rarer
  int late_view_interval_factor = 8;  ///< factor on `view_interval` from then on
  /// Likewise while the newest view fits, of a vehicle that never knew a place.
  int entering_view_interval_factor = 3;
  int max_view_count = 4;  ///< views that are kept
  /// Views that odometry joins less certainly than this are dropped.
  double max_view_sigma_m = 2.0;
  double max_view_sigma_rad = 0.2;

  int candidate_count = 60;      ///< places that are tried for each view
  int max_kept_candidates = 32;  ///< that are kept for the next one
  /// Points of a view in a fine fit, which compares places, and in a coarse one, which drops those
  /// that are none.
  int fine_point_count = 400;
  int coarse_point_count = 100;
  /// Step of the search; finer in a small region.
  double cell_m = 1.0;
  double small_region_cell_m = 0.5;
  double small_region_radius_m = 40.0;

  /// Log-likelihood of a score of 1 (METHOD eq 38). Near the score of a place that fits, it is that
  /// of some twenty independent points. It is linear in the score: where little fits, a logarithm
  /// would make much of a little more.
  double log_likelihood_per_score = 36.0;
  /// Candidates are dropped that lack more than this to the best: in score after a coarse fit, in
  /// log-likelihood after the fine fit of a new one, and over all views.
  double coarse_score_margin = 0.2;
  double new_candidate_margin = 4.0;
  double candidate_margin = 10.0;
  /// Poses nearer to one another are the same place.
  double same_place_m = 1.0;
  double same_place_rad = 0.1;
  /// What a registration is off by, as odometry between two views sees it.
  double registration_sigma_m = 0.3;
  double registration_sigma_rad = 0.02;

  /// Work in one call, in units of some 0.04 us: about ten milliseconds.
  double max_work = 250e3;
};
std::span<const OptionField<GlobalLocalizerOptions>> FieldsOf(
    const GlobalLocalizerOptions& options);
absl::Status Validate(const GlobalLocalizerOptions& options);

}  // namespace dcloc
