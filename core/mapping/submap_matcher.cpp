#include "core/mapping/submap_matcher.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/thinning.h"
#include "core/registration/correlative_search.h"
#include "core/registration/gicp.h"
#include "core/registration/observability.h"
#include "core/relocalization/view.h"
#include "core/uncertainty/registration_factor.h"

namespace dcloc {

std::span<const OptionField<SubmapMatcherOptions>> FieldsOf(
    const SubmapMatcherOptions& /*options*/) {
  using O = SubmapMatcherOptions;
  static constexpr OptionField<O> kFields[] = {
      {"shared_sigma_m", &O::shared_sigma_m, 1e-3, 10},
      {"shared_sigma_rad", &O::shared_sigma_rad, 1e-5, 1},
      {"search_sigma_m", &O::search_sigma_m, 0, 100, "every guess is searched around"},
      {"search_sigmas", &O::search_sigmas, 0.5, 10},
      {"candidate_count", &O::candidate_count, 1, 100},
      {"search_point_count", &O::search_point_count, 10, 10'000},
      {"search_window_cells", &O::search_window_cells, 2, 1000},
      {"max_search_cell_m", &O::max_search_cell_m, 0.1, 5},
      {"min_search_cell_m", &O::min_search_cell_m, 0.1, 5},
  };
  return kFields;
}

absl::Status Validate(const SubmapMatcherOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("gicp", Validate(options.gicp)));
  return status;
}

std::optional<SubmapMatch> SubmapMatcher::Match(std::span<const GaussianPoint<2>> live,
                                                const LocalMap<2>& target, const SubmapGuess& guess,
                                                const RegistrationGate& gate) {
  if (live.empty() || target.empty()) return std::nullopt;
  double start_sigma_m = guess.sigma_m;
  std::optional<Registration<2>> best;
  for (const Pose2& start : Starts(live, target, guess, start_sigma_m)) {
    GicpOptions gicp = options_.gicp;
    gicp.initial_blur_m = start_sigma_m;
    const Registration<2> one = RegisterGicp<2>(live, target, start, gicp, workspace_.finder);
    if (gate.Accepts(one) && (!best || one.score > best->score)) best = one;
  }
  if (!best) return std::nullopt;

  const ObservabilityOptions observability;
  const Observability observed =
      Observe<2>(live, target, best->T_local_vehicle, best->covariance,
                 {.max_distance_m = options_.gicp.max_correspondence_distance_m,
                  .gate_sigmas = options_.gicp.gate_sigmas},
                 observability, workspace_.observed_points, workspace_.map_fit);
  Eigen::Matrix3d covariance = ResidualScaledCovariance<2>(*best);
  covariance.topLeftCorner<2, 2>() +=
      observed.DegeneracyCovariance(observability.degenerate_sigma_m);
  covariance.diagonal() +=
      Eigen::Vector3d(std::pow(options_.shared_sigma_m, 2), std::pow(options_.shared_sigma_m, 2),
                      std::pow(options_.shared_sigma_rad, 2));
  return SubmapMatch{.T_target_live = {.pose = best->T_local_vehicle, .covariance = covariance},
                     .inlier_count = best->inlier_count,
                     .overlap = best->overlap,
                     .residual_scale = best->residual_scale};
}

std::vector<Pose2> SubmapMatcher::Starts(std::span<const GaussianPoint<2>> live,
                                         const LocalMap<2>& target, const SubmapGuess& guess,
                                         double& start_sigma_m) const {
  if (guess.sigma_m < options_.search_sigma_m) return {guess.T_target_live};
  const double max_separation_m = options_.search_sigmas * guess.sigma_m;
  const double cell_m = std::clamp(2.0 * max_separation_m / options_.search_window_cells,
                                   options_.min_search_cell_m, options_.max_search_cell_m);
  start_sigma_m = cell_m;
  const LikelihoodField field(target, cell_m);
  const std::vector<Eigen::Vector2f> points =
      PositionsOf<2>(EvenSubsample(live, options_.search_point_count));
  constexpr double kAllAround_rad = 3.1;  // short of a half turn, which would be searched twice
  const double reach_rad = std::min(options_.search_sigmas * guess.sigma_rad, kAllAround_rad);
  std::vector<Pose2> starts;
  for (const PoseCandidate& candidate :
       CorrelativeSearch(points, field,
                         {.centre_local_vehicle = guess.T_target_live,
                         .translation_m = max_separation_m,
                         .rotation_rad = reach_rad},
                         options_.candidate_count)) {
    starts.push_back(candidate.T_local_vehicle);
  }
  return starts;
}

}  // namespace dcloc
