#include "core/registration/map_matcher.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/pose_estimate.h"
#include "core/geometry/thinning.h"
#include "core/registration/radial_statistics.h"
#include "core/registration/rigid_ransac.h"

namespace dcloc {
namespace {

// A local map holds more landmarks than a view shows of it; each shall find its own.
constexpr std::size_t kLandmarksPerSearchPoint = 4;
// Two neighbours of each descriptor give RANSAC more right pairs to choose from than one.
constexpr int kDescriptorNeighbours = 2;

// xy of each n-th point, at most `max_count`.
template <typename Point>
std::vector<Eigen::Vector2f> EveryNth(std::span<const Point> points, std::size_t max_count) {
  const std::size_t step = StepToKeep(max_count, points.size());
  std::vector<Eigen::Vector2f> chosen;
  for (std::size_t i = 0; i < points.size(); i += step) {
    chosen.push_back(points[i].mean_m.template head<2>().template cast<float>());
  }
  return chosen;
}

// A planar candidate with the rest of the predicted pose.
template <int Dim>
Pose<Dim> Lift(const Pose2& planar, const Pose<Dim>& predicted) {
  if constexpr (Dim == 2) {
    return planar;
  } else {
    const Pose3 rest = Embed(Flatten(predicted)).Inverse() * predicted;
    return Embed(planar) * rest;
  }
}

template <int Dim>
Pose2 Planar(const Pose<Dim>& pose) {
  if constexpr (Dim == 2) {
    return pose;
  } else {
    return Flatten(pose);
  }
}

template <int Dim>
double TranslationSigma(const TangentMatrix<Dim>& covariance) {
  return std::sqrt(covariance.template topLeftCorner<2, 2>().trace());
}

// Of what could be found.
template <int Dim>
double ObservedSigma(const TangentMatrix<Dim>& covariance, const Observability& observability) {
  double variance_m2 = 0.0;
  for (const Observability::Direction& direction : observability.directions) {
    if (!direction.observed) continue;
    variance_m2 += direction.axis.dot(covariance.template topLeftCorner<2, 2>() * direction.axis);
  }
  return std::sqrt(variance_m2);
}

template <int Dim>
double YawSigma(const TangentMatrix<Dim>& covariance) {
  return std::sqrt(covariance(Pose<Dim>::kDof - 1, Pose<Dim>::kDof - 1));
}

// Log-posterior of a registration up to a constant: the score is a likelihood per point, of which
// about this many are independent; the prediction is the prior.
template <int Dim>
double Plausibility(const Registration<Dim>& registration, const PoseEstimate<Dim>& predicted,
                    const MapMatcherOptions& options) {
  constexpr double kMinScore = 1e-9;
  const Tangent<Dim> apart = Log(predicted.pose.Inverse() * registration.T_local_vehicle);
  return options.independent_point_count * std::log(std::max(kMinScore, registration.score)) -
         0.5 * apart.dot(predicted.covariance.ldlt().solve(apart));
}

// Whether every other place that was found is less plausible than the best by `min_lead`, and none
// fits the scans better: what the prediction alone decides is not decided.
template <int Dim>
bool StandsOut(const Registration<Dim>& best, std::span<const Registration<Dim>> found,
               const PoseEstimate<Dim>& predicted, const MapMatcherOptions& options) {
  const double least = Plausibility(best, predicted, options) - options.wide_min_lead;
  return std::ranges::none_of(found, [&](const Registration<Dim>& other) {
    const Pose<Dim> apart = best.T_local_vehicle.Inverse() * other.T_local_vehicle;
    return apart.translation_m.norm() > options.same_place_m &&
           (other.score > best.score || Plausibility(other, predicted, options) > least);
  });
}

}  // namespace

std::span<const OptionField<RegistrationGate>> FieldsOf(const RegistrationGate& /*options*/) {
  using O = RegistrationGate;
  static constexpr OptionField<O> kFields[] = {
      {"min_inlier_count", &O::min_inlier_count, 1, 100'000},
      {"min_overlap", &O::min_overlap, 0, 1, "the count alone decides"},
      {"max_residual_scale", &O::max_residual_scale, 1e-6, 1000},
  };
  return kFields;
}

absl::Status Validate(const RegistrationGate& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::span<const OptionField<MapMatcherOptions>> FieldsOf(const MapMatcherOptions& /*options*/) {
  using O = MapMatcherOptions;
  static constexpr OptionField<O> kFields[] = {
      {"local_map_radius_m", &O::local_map_radius_m, 10, 1000},
      {"search_sigma_m", &O::search_sigma_m, 0, 100, "every prediction is searched around"},
      {"search_sigma_rad", &O::search_sigma_rad, 0, 10, "every prediction is searched around"},
      {"candidate_count", &O::candidate_count, 0, 1000, "the initial guess alone is tried"},
      {"wide_sigma_m", &O::wide_sigma_m, 0, 100,
       "every prediction that is searched around is wide"},
      {"wide_candidate_count", &O::wide_candidate_count, 0, 1000,
       "the initial guess alone is tried"},
      {"wide_min_overlap", &O::wide_min_overlap, 0, 1, "any overlap is enough"},
      {"wide_min_lead", &O::wide_min_lead, 0, 1000, "the best one needs no lead"},
      {"search_point_count", &O::search_point_count, 10, 100'000},
      {"search_cell_m", &O::search_cell_m, 0.01, 10},
      {"search_sigmas", &O::search_sigmas, 1e-6, 100},
      {"max_search_m", &O::max_search_m, 1e-6, 100},
      {"max_search_rad", &O::max_search_rad, 1e-6, 4},
      {"search_guess_sigma_m", &O::search_guess_sigma_m, 0, 10, "what a search finds is exact"},
      {"independent_point_count", &O::independent_point_count, 1, 1e6},
      {"same_place_m", &O::same_place_m, 1e-6, 100},
  };
  return kFields;
}

absl::Status Validate(const MapMatcherOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("gicp", Validate(options.gicp)));
  status.Update(Within("gate", Validate(options.gate)));
  status.Update(Within("observability", Validate(options.observability)));
  return status;
}

template <int Dim>
bool MapMatcher<Dim>::MoveTo(const Eigen::Vector3d& p_map, RegistrationWorkspace<Dim>& workspace) {
  const std::optional<std::size_t> nearest =
      map_->NearestKeyframe(p_map, options_.local_map_radius_m);
  if (!nearest || nearest == keyframe_) return false;
  keyframe_ = nearest;
  local_map_.MoveTo(*map_, p_map, options_.local_map_radius_m, workspace.local_map);
  T_map_local_ = local_map_.T_map_local();
  search_.reset();
  return true;
}

template <int Dim>
std::optional<Registration<Dim>> MapMatcher<Dim>::Match(std::span<const GaussianPoint<Dim>> live,
                                                        const PoseEstimate<Dim>& predicted,
                                                        const Observability& observability,
                                                        std::uint64_t seed,
                                                        RegistrationWorkspace<Dim>& workspace) {
  if (local_map_.empty() || live.empty()) return std::nullopt;
  const double sigma_m = ObservedSigma<Dim>(predicted.covariance, observability);
  if (sigma_m > options_.search_sigma_m ||
      YawSigma<Dim>(predicted.covariance) > options_.search_sigma_rad) {
    return Search(live, predicted, sigma_m > options_.wide_sigma_m, seed, workspace);
  }
  search_.reset();
  const Registration<Dim> refined = Refine(live, predicted.pose, 0.0, workspace);
  return options_.gate.Accepts(refined) ? std::optional(refined) : std::nullopt;
}

template <int Dim>
std::optional<Registration<Dim>> MapMatcher<Dim>::Search(std::span<const GaussianPoint<Dim>> live,
                                                         const PoseEstimate<Dim>& predicted,
                                                         bool wide, std::uint64_t seed,
                                                         RegistrationWorkspace<Dim>& workspace) {
  std::vector<Registration<Dim>> found = {Refine(live, predicted.pose, 0.0, workspace)};
  const int count = wide ? options_.wide_candidate_count : options_.candidate_count;
  for (const Pose2& candidate : Candidates(live, predicted, count, seed)) {
    found.push_back(Refine(live, Lift<Dim>(candidate, predicted.pose),
                           options_.search_guess_sigma_m, workspace));
  }
  const Registration<Dim> best = *std::ranges::max_element(
      found, {},
      [&](const Registration<Dim>& one) { return Plausibility(one, predicted, options_); });
  if (!options_.gate.Accepts(best)) return std::nullopt;
  // Where little of the view is mapped, too, a wrong place is as good as the right one.
  const bool sees_little = best.overlap < options_.wide_min_overlap;
  if (wide && sees_little) return std::nullopt;
  if ((wide || sees_little) && !StandsOut<Dim>(best, found, predicted, options_)) {
    return std::nullopt;
  }
  return best;
}

template <int Dim>
std::vector<Pose2> MapMatcher<Dim>::Candidates(std::span<const GaussianPoint<Dim>> live,
                                               const PoseEstimate<Dim>& predicted, int count,
                                               std::uint64_t seed) {
  if (!search_) {
    search_.emplace();
    search_->field = LikelihoodField(local_map_, options_.search_cell_m);
    search_->landmarks =
        EveryNth(local_map_.points(),
                 kLandmarksPerSearchPoint * static_cast<std::size_t>(options_.search_point_count));
    search_->descriptors = RadialStatistics(search_->landmarks);
  }
  const SearchWindow window{
      .centre_local_vehicle = Planar<Dim>(predicted.pose),
      .translation_m =
          std::min(options_.max_search_m,
                   options_.search_sigmas * TranslationSigma<Dim>(predicted.covariance)),
      .rotation_rad = std::min(options_.max_search_rad,
                               options_.search_sigmas * YawSigma<Dim>(predicted.covariance))};
  const std::vector<Eigen::Vector2f> points =
      EveryNth(live, static_cast<std::size_t>(options_.search_point_count));
  std::vector<Pose2> candidates;
  for (const PoseCandidate& found : CorrelativeSearch(points, search_->field, window, count)) {
    candidates.push_back(found.T_local_vehicle);
  }
  const std::vector<IndexPair> pairs =
      MutualNearest(search_->descriptors, RadialStatistics(points), kDescriptorNeighbours);
  if (const auto match = MatchRigid(search_->landmarks, points, pairs, seed)) {
    candidates.push_back(match->T_a_b);
  }
  return candidates;
}

template <int Dim>
std::optional<Registration<Dim>> MapMatcher<Dim>::MatchFound(
    std::span<const GaussianPoint<Dim>> live, const Pose3& T_map_vehicle,
    const RegistrationGate& gate, RegistrationWorkspace<Dim>& workspace) {
  MoveTo(T_map_vehicle.translation_m, workspace);
  const Pose3 T_local_vehicle = T_map_local_.Inverse() * T_map_vehicle;
  const Registration<Dim> registration =
      Refine(live, FromSpace<Dim>(T_local_vehicle, Matrix6d::Zero()).pose,
             options_.search_guess_sigma_m, workspace);
  return gate.Accepts(registration) ? std::optional(registration) : std::nullopt;
}

template <int Dim>
CorrespondenceGates MapMatcher<Dim>::Gates() const {
  return {.max_distance_m = options_.gicp.max_correspondence_distance_m,
          .gate_sigmas = options_.gicp.gate_sigmas};
}

template <int Dim>
std::span<const Correspondence<Dim>> MapMatcher<Dim>::Correspondences(
    std::span<const GaussianPoint<Dim>> live, const Pose<Dim>& T_local_vehicle,
    RegistrationWorkspace<Dim>& workspace) const {
  if (!method_->PreparesFinder()) workspace.finder.Begin(live, local_map_, Gates());
  return workspace.finder.Find(T_local_vehicle, 0.0);
}

template <int Dim>
double MapMatcher<Dim>::Fit(std::span<const GaussianPoint<Dim>> points,
                            const Pose<Dim>& T_local_vehicle, double sigma_m,
                            RegistrationWorkspace<Dim>& workspace) const {
  workspace.map_fit.Begin(points, local_map_, Gates(), T_local_vehicle, sigma_m);
  return workspace.map_fit.At(T_local_vehicle.translation_m);
}

template <int Dim>
void MapMatcher<Dim>::FitsAt(std::span<const Pose2> T_vehicle_places,
                             std::span<const GaussianPoint<Dim>> points,
                             const Pose<Dim>& T_local_vehicle, double sigma_m,
                             RegistrationWorkspace<Dim>& workspace,
                             std::vector<double>& fits) const {
  workspace.map_fit.Begin(points, local_map_, Gates(), T_local_vehicle, sigma_m);
  const Eigen::Matrix<double, Dim, 2> axes = T_local_vehicle.Rotation().template leftCols<2>();
  fits.clear();
  for (const Pose2& place : T_vehicle_places) {
    fits.push_back(workspace.map_fit.At(T_local_vehicle.translation_m + axes * place.translation_m,
                                        place.yaw_rad));
  }
}

template <int Dim>
typename MapMatcher<Dim>::RegisteredPlace MapMatcher<Dim>::RegisterPlace(
    std::span<const GaussianPoint<Dim>> live, const Pose<Dim>& T_local_vehicle,
    const Pose2& T_vehicle_place, RegistrationWorkspace<Dim>& workspace) const {
  const Pose2 vehicle = Planar<Dim>(T_local_vehicle);
  const Pose<Dim> start = Lift<Dim>(vehicle * T_vehicle_place, T_local_vehicle);
  const Registration<Dim> registration =
      method_->Register({.points = live,
                         .map = local_map_,
                         .T_local_vehicle_guess = start,
                         .guess_sigma_m = options_.search_guess_sigma_m,
                         .effort = kComparingEffort},
                        workspace);
  return {.T_vehicle_place = vehicle.Inverse() * Planar<Dim>(registration.T_local_vehicle),
          .score = registration.score};
}

template <int Dim>
Observability MapMatcher<Dim>::Observed(std::span<const GaussianPoint<Dim>> live,
                                        const Registration<Dim>& registration,
                                        RegistrationWorkspace<Dim>& workspace) const {
  return Observe<Dim>(live, local_map_, registration.T_local_vehicle, registration.covariance,
                      Gates(), options_.observability, workspace.observed_points,
                      workspace.map_fit);
}

template <int Dim>
Registration<Dim> MapMatcher<Dim>::Refine(std::span<const GaussianPoint<Dim>> live,
                                          const Pose<Dim>& start, double blur_m,
                                          RegistrationWorkspace<Dim>& workspace) const {
  return method_->Register(
      {.points = live, .map = local_map_, .T_local_vehicle_guess = start, .guess_sigma_m = blur_m},
      workspace);
}

template class MapMatcher<2>;
template class MapMatcher<3>;

}  // namespace dcloc
