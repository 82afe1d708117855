#include "core/registration/map_matcher.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/localizer/planar_or_spatial.h"
#include "core/localizer/workspace.h"
#include "core/registration/radial_statistics.h"
#include "core/registration/rigid_ransac.h"

namespace dcloc {
namespace {

// Searches score every point at every pose: this many are enough to tell poses apart.
constexpr std::size_t kSearchPoints = 300;
constexpr double kFineCell_m = 0.25;

template <typename Point>
std::vector<Eigen::Vector2f> Thinned(std::span<const Point> points, std::size_t max_count) {
  const std::size_t stride = std::max<std::size_t>(1, (points.size() + max_count - 1) / max_count);
  std::vector<Eigen::Vector2f> thinned;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    thinned.push_back(points[i].mean_m.template head<2>().template cast<float>());
  }
  return thinned;
}

// A planar hypothesis with the rest of the predicted pose.
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
double Plausibility(const Registration<Dim>& registration, const PoseEstimate<Dim>& predicted) {
  constexpr double kIndependentPoints = 20.0;
  constexpr double kMinScore = 1e-9;
  const Tangent<Dim> apart = Log(predicted.pose.Inverse() * registration.T_local_vehicle);
  return kIndependentPoints * std::log(std::max(kMinScore, registration.score)) -
         0.5 * apart.dot(predicted.covariance.ldlt().solve(apart));
}

// Whether every other place that was found is less plausible than the best by `min_lead`, and none
// fits the scans better: what the prediction alone decides is not decided.
template <int Dim>
bool StandsOut(const Registration<Dim>& best, std::span<const Registration<Dim>> found,
               const PoseEstimate<Dim>& predicted, double min_lead) {
  constexpr double kSamePlace_m = 1.0;
  const double least = Plausibility(best, predicted) - min_lead;
  return std::ranges::none_of(found, [&](const Registration<Dim>& other) {
    const Pose<Dim> apart = best.T_local_vehicle.Inverse() * other.T_local_vehicle;
    return apart.translation_m.norm() > kSamePlace_m &&
           (other.score > best.score || Plausibility(other, predicted) > least);
  });
}

}  // namespace

template <int Dim>
bool MapMatcher<Dim>::MoveTo(const Eigen::Vector3d& p_map) {
  const std::optional<std::size_t> nearest =
      map_->NearestKeyframe(p_map, options_.match.local_map_radius_m);
  if (!nearest || nearest == keyframe_) return false;
  keyframe_ = nearest;
  local_map_.MoveTo(*map_, p_map, options_.match.local_map_radius_m,
                    Workspace<Dim>::OfThisThread().local_map);
  T_map_local_ = local_map_.T_map_local();
  search_.reset();
  return true;
}

template <int Dim>
std::optional<Registration<Dim>> MapMatcher<Dim>::Match(std::span<const GaussianPoint<Dim>> live,
                                                        const PoseEstimate<Dim>& predicted,
                                                        const Observability& observability,
                                                        std::uint64_t seed) {
  if (local_map_.empty() || live.empty()) return std::nullopt;
  const double sigma_m = ObservedSigma<Dim>(predicted.covariance, observability);
  if (sigma_m > options_.match.search_sigma_m ||
      YawSigma<Dim>(predicted.covariance) > options_.match.search_sigma_rad) {
    return Search(live, predicted, sigma_m > options_.match.wide_sigma_m, seed);
  }
  search_.reset();
  const Registration<Dim> refined = Refine(live, predicted.pose, 0.0);
  return IsAcceptable(refined) ? std::optional(refined) : std::nullopt;
}

template <int Dim>
std::optional<Registration<Dim>> MapMatcher<Dim>::Search(std::span<const GaussianPoint<Dim>> live,
                                                         const PoseEstimate<Dim>& predicted,
                                                         bool wide, std::uint64_t seed) {
  const MatchOptions& match = options_.match;
  std::vector<Registration<Dim>> found = {Refine(live, predicted.pose, 0.0)};
  const int count = wide ? match.wide_hypotheses : match.hypotheses;
  for (const Pose2& hypothesis : Hypotheses(live, predicted, count, seed)) {
    found.push_back(Refine(live, Lift<Dim>(hypothesis, predicted.pose), 0.3));
  }
  const Registration<Dim> best = *std::ranges::max_element(
      found, {}, [&](const Registration<Dim>& one) { return Plausibility(one, predicted); });
  if (!IsAcceptable(best)) return std::nullopt;
  // Where little of the view is mapped, too, a wrong place is as good as the right one.
  const bool sees_little = best.overlap < match.wide_min_overlap;
  if (wide && sees_little) return std::nullopt;
  if ((wide || sees_little) && !StandsOut<Dim>(best, found, predicted, match.wide_min_lead)) {
    return std::nullopt;
  }
  return best;
}

template <int Dim>
std::vector<Pose2> MapMatcher<Dim>::Hypotheses(std::span<const GaussianPoint<Dim>> live,
                                               const PoseEstimate<Dim>& predicted, int count,
                                               std::uint64_t seed) {
  constexpr double kSigmas = 3.0;
  constexpr double kMaxSearch_m = 10.0;
  constexpr double kMaxSearch_rad = 0.8;
  if (!search_) {
    search_.emplace();
    search_->field = LikelihoodField(local_map_, kFineCell_m);
    search_->landmarks = Thinned(local_map_.points(), 4 * kSearchPoints);
    search_->descriptors = RadialStatistics(search_->landmarks);
  }
  const SearchWindow window{
      .centre_local_vehicle = Planar<Dim>(predicted.pose),
      .translation_m =
          std::min(kMaxSearch_m, kSigmas * TranslationSigma<Dim>(predicted.covariance)),
      .rotation_rad = std::min(kMaxSearch_rad, kSigmas * YawSigma<Dim>(predicted.covariance))};
  const std::vector<Eigen::Vector2f> points = Thinned(live, kSearchPoints);
  std::vector<Pose2> hypotheses;
  for (const PoseHypothesis& found : CorrelativeSearch(points, search_->field, window, count)) {
    hypotheses.push_back(found.T_local_vehicle);
  }
  const std::vector<IndexPair> pairs =
      MutualNearest(search_->descriptors, RadialStatistics(points), 2);
  if (const auto match = MatchRigid(search_->landmarks, points, pairs, seed)) {
    hypotheses.push_back(match->T_a_b);
  }
  return hypotheses;
}

template <int Dim>
std::optional<Registration<Dim>> MapMatcher<Dim>::MatchFound(
    std::span<const GaussianPoint<Dim>> live, const Pose3& T_map_vehicle) {
  constexpr double kDriftBlur_m = 0.3;
  MoveTo(T_map_vehicle.translation_m);
  const Pose3 T_local_vehicle = T_map_local_.Inverse() * T_map_vehicle;
  const Registration<Dim> registration =
      Refine(live, FromSpace<Dim>(T_local_vehicle, Matrix6d::Zero()).pose, kDriftBlur_m);
  const bool is_acceptable = IsAcceptable(registration) &&
                             registration.inlier_count >= options_.match.global_min_inlier_count &&
                             registration.overlap >= options_.match.global_min_overlap;
  return is_acceptable ? std::optional(registration) : std::nullopt;
}

template <int Dim>
std::span<const Correspondence<Dim>> MapMatcher<Dim>::Matches(
    const Pose<Dim>& T_local_vehicle) const {
  return Workspace<Dim>::OfThisThread().finder.Find(T_local_vehicle, 0.0);
}

template <int Dim>
Observability MapMatcher<Dim>::Observed(std::span<const GaussianPoint<Dim>> live,
                                        const Registration<Dim>& registration) const {
  Workspace<Dim>& workspace = Workspace<Dim>::OfThisThread();
  return Observe<Dim>(live, local_map_, registration.T_local_vehicle, registration.covariance,
                      {.reach_m = options_.gicp.reach_m, .gate_sigmas = options_.gicp.gate_sigmas},
                      workspace.chosen_points, workspace.chosen_finder);
}

template <int Dim>
Registration<Dim> MapMatcher<Dim>::Refine(std::span<const GaussianPoint<Dim>> live,
                                          const Pose<Dim>& start, double blur_m) {
  GicpOptions gicp = options_.gicp;
  gicp.initial_blur_m = blur_m;
  return RegisterGicp<Dim>(live, local_map_, start, gicp, Workspace<Dim>::OfThisThread().finder);
}

template <int Dim>
bool MapMatcher<Dim>::IsAcceptable(const Registration<Dim>& registration) const {
  return registration.inlier_count >= options_.match.min_inlier_count &&
         registration.overlap >= options_.match.min_overlap &&
         registration.residual_scale <= options_.match.max_residual_scale;
}

template class MapMatcher<2>;
template class MapMatcher<3>;

}  // namespace dcloc
