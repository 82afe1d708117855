#include "core/relocalization/global_localizer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/covariance.h"
#include "core/geometry/pose_estimate.h"

namespace dcloc {
namespace {

constexpr std::size_t kMaxViews = 4;
constexpr std::size_t kMaxKeptCandidates = 32;
// Of a view's points so many tell places apart, and so many what is no place at all.
constexpr std::size_t kFinePoints = 400;
constexpr std::size_t kCoarsePoints = 100;
// What is done in one go; a unit takes some 0.04 us.
constexpr double kMaxWork = 250e3;
constexpr double kSearchWork = 24e3;  // of a piece of a search
constexpr double kOdometryBlur_m = 0.3;
// Of the overlap that a place must have once it is found, so much in each view: the first ones may
// show ground from before the map's beginning.
constexpr double kViewShare = 0.83;
// Steps of the search: fine ones on little ground, which is most alike within itself.
constexpr double kCell_m = 1.0;
constexpr double kLittleCell_m = 0.5;
constexpr double kLittleGround_m = 40.0;
// What a score is worth as a log-likelihood. Near the score of a place that fits, some twenty
// independent points; linear, as where little fits a logarithm would make much of a little more.
constexpr double kPerScore = 36.0;

template <int Dim>
std::vector<Eigen::Vector2f> PositionsOf(std::span<const GaussianPoint<Dim>> points) {
  std::vector<Eigen::Vector2f> positions;
  positions.reserve(points.size());
  for (const GaussianPoint<Dim>& point : points) {
    positions.push_back(point.mean_m.template head<2>().template cast<float>());
  }
  return positions;
}

// An even choice.
template <int Dim>
std::vector<GaussianPoint<Dim>> Subsample(std::span<const GaussianPoint<Dim>> points,
                                          std::size_t max_count) {
  std::vector<GaussianPoint<Dim>> thinned;
  const std::size_t count = std::min(points.size(), max_count);
  thinned.reserve(count);
  for (std::size_t i = 0; i < count; ++i) thinned.push_back(points[i * points.size() / count]);
  return thinned;
}

bool IsSamePlace(const Pose3& a, const Pose3& b) {
  constexpr double kSame_m = 1.0;
  constexpr double kSame_rad = 0.1;
  return (a.translation_m - b.translation_m).head<2>().norm() < kSame_m &&
         std::abs(WrapAngle(Yaw(a.rotation) - Yaw(b.rotation))) < kSame_rad;
}

Motion Reversed(const Motion& motion) {
  return {.T_from_to = motion.T_from_to.Inverse(),
          .covariance = InvertCovariance<3>(motion.T_from_to, motion.covariance)};
}

// Squared distance of a registered pose from the one that odometry expects, in units of what both
// are off by.
template <int Dim>
double SquaredDistance(const Pose<Dim>& apart, const TangentMatrix<Dim>& odometry) {
  constexpr double kRegistration_m = 0.3;
  constexpr double kRegistration_rad = 0.02;
  TangentMatrix<Dim> covariance = odometry;
  covariance.diagonal().template head<Dim>().array() += kRegistration_m * kRegistration_m;
  covariance.diagonal().template tail<Pose<Dim>::kDof - Dim>().array() +=
      kRegistration_rad * kRegistration_rad;
  const Tangent<Dim> difference = Log(apart);
  return difference.dot(covariance.ldlt().solve(difference));
}

}  // namespace

std::span<const OptionField<GlobalLocalizerOptions>> FieldsOf(
    const GlobalLocalizerOptions& /*options*/) {
  using O = GlobalLocalizerOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_view_span_ms", &O::min_view_span, 0, 1e6, "one scan is a view"},
      {"min_distance_m", &O::min_distance_m, 0, 1000, "two views are enough"},
      {"min_lead", &O::min_lead, 0, 1000, "the best one needs no lead"},
      {"candidate_count", &O::candidate_count, 1, 10'000},
  };
  return kFields;
}

absl::Status Validate(const GlobalLocalizerOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("gate", Validate(options.gate)));
  return status;
}

template <int Dim>
void GlobalLocalizer<Dim>::OnMotion(const Motion& motion) {
  if (views_.empty()) return;
  since_view_ = Compose(since_view_, motion);
  since_view_m_ += motion.T_from_to.translation_m.norm();
  // Views that odometry does not join any more.
  constexpr double kMaxSigma_m = 2.0;
  constexpr double kMaxSigma_rad = 0.2;
  const Matrix6d& covariance = since_view_.covariance;
  if (std::sqrt(covariance.topLeftCorner<2, 2>().trace()) > kMaxSigma_m ||
      std::sqrt(covariance(5, 5)) > kMaxSigma_rad) {
    const int view_count = view_count_;
    Clear();
    view_count_ = view_count;  // the search for it goes on
  }
}

// Views share scans where they follow one another sooner than a sub-map is long, so that little way
// is enough between two of them; the place that wins must hold over more.
template <int Dim>
bool GlobalLocalizer<Dim>::WantsView(Stamp stamp) const {
  if (phase_ != Phase::kIdle || winner_) return false;
  if (views_.empty()) return true;
  constexpr double kWay_m = 4.0;
  constexpr auto kInterval = std::chrono::milliseconds(400);
  // Who is where there is no map must not search it all the time.
  constexpr int kEagerViews = 8;
  const auto interval = view_count_ < kEagerViews ? kInterval : 8 * kInterval;
  return since_view_m_ >= kWay_m && stamp - view_stamp_ >= interval;
}

template <int Dim>
void GlobalLocalizer<Dim>::AddView(Stamp stamp, std::span<const GaussianPoint<Dim>> live,
                                   const std::optional<SearchRegion>& region) {
  if (views_.size() == kMaxViews) {
    views_.erase(views_.begin());
    for (Candidate& candidate : candidates_) candidate.fits.erase(candidate.fits.begin());
  }
  views_.push_back({.live = Subsample(live, kFinePoints),
                    .coarse_points = Subsample(live, kCoarsePoints),
                    .motion = std::exchange(since_view_, {}),
                    .way_m = std::exchange(since_view_m_, 0.0)});
  for (Candidate& candidate : candidates_) candidate.fits.emplace_back();
  view_stamp_ = stamp;
  ++view_count_;
  region_ = region;
  const bool is_little = region && region->radius_m <= kLittleGround_m;
  search_.emplace(map_, PositionsOf(live),
                  PlaceSearchOptions{.cell_m = is_little ? kLittleCell_m : kCell_m,
                                     .max_count = options_.candidate_count,
                                     .region = region});
  phase_ = Phase::kExtend;
}

template <int Dim>
std::optional<Pose3> GlobalLocalizer<Dim>::Continue(RegistrationWorkspace<Dim>& workspace) {
  work_ = 0.0;
  while (work_ < kMaxWork && phase_ != Phase::kIdle) DoNextPiece(workspace);
  if (!winner_ || Way() < options_.min_distance_m) return std::nullopt;
  return *winner_ * since_view_.T_from_to;
}

// From the oldest view on.
template <int Dim>
double GlobalLocalizer<Dim>::Way() const {
  double way_m = since_view_m_;
  for (std::size_t i = 1; i < views_.size(); ++i) way_m += views_[i].way_m;
  return way_m;
}

template <int Dim>
void GlobalLocalizer<Dim>::Clear() {
  *this = GlobalLocalizer(map_, options_, local_map_radius_m_, gicp_);
}

template <int Dim>
void GlobalLocalizer<Dim>::DoNextPiece(RegistrationWorkspace<Dim>& workspace) {
  switch (phase_) {
    case Phase::kExtend:
      if (!FillNextFit(workspace)) phase_ = Phase::kSearch;
      break;
    case Phase::kSearch:
      if (!search_->done()) {
        search_->SearchOn();
        work_ += kSearchWork;
        break;
      }
      cell_m_ = search_->cell_m();
      places_ = search_->Best();
      std::ranges::reverse(places_);
      search_.reset();
      phase_ = Phase::kCoarseFit;
      break;
    case Phase::kCoarseFit:
      if (!places_.empty()) {
        FitCoarsely(places_.back(), workspace);
        places_.pop_back();
        break;
      }
      KeepPromising();
      phase_ = Phase::kFineFit;
      break;
    case Phase::kFineFit:
      if (!coarse_fits_.empty()) {
        FitFinely(coarse_fits_.back(), workspace);
        coarse_fits_.pop_back();
        break;
      }
      DropUnlikelyNewcomers();
      phase_ = Phase::kBackfill;
      break;
    case Phase::kBackfill:
      if (FillNextFit(workspace)) break;
      KeepBestCandidates();
      winner_ = Winner();
      phase_ = Phase::kIdle;
      break;
    case Phase::kIdle:
      break;
  }
}

// Most places that a search finds are none: a coarse_points points and steps tell.
template <int Dim>
void GlobalLocalizer<Dim>::FitCoarsely(const PlaceHypothesis& place,
                                       RegistrationWorkspace<Dim>& workspace) {
  const Pose3 T_map_vehicle =
      map_->keyframe(place.keyframe).T_map_keyframe * Embed(place.T_keyframe_vehicle);
  if (IsKnown(T_map_vehicle)) return;
  GicpOptions gicp = gicp_;
  gicp.max_iterations = 8;
  gicp.translation_tolerance_m = 0.02;
  gicp.rotation_tolerance_rad = 0.002;
  // Half a step off in position and heading: about as much as a step.
  gicp.initial_blur_m = cell_m_;
  if (const auto registration =
          Register(views_.back().coarse_points, T_map_vehicle, gicp, workspace)) {
    coarse_fits_.push_back(
        {.T_map_vehicle = InMap(registration->T_local_vehicle), .score = registration->score});
  }
}

template <int Dim>
void GlobalLocalizer<Dim>::KeepPromising() {
  constexpr double kHopeless = 0.2;
  double best = 0.0;
  for (const CoarseFit& fit : coarse_fits_) best = std::max(best, fit.score);
  for (const Candidate& one : candidates_) {
    best = std::max(best, one.fits.back()->log_likelihood / kPerScore);
  }
  std::erase_if(coarse_fits_, [&](const CoarseFit& fit) { return fit.score < best - kHopeless; });
  std::ranges::stable_sort(coarse_fits_, {}, &CoarseFit::score);
}

// A place that no candidate has come to yet is a candidate of its own.
template <int Dim>
void GlobalLocalizer<Dim>::FitFinely(const CoarseFit& fit, RegistrationWorkspace<Dim>& workspace) {
  if (IsKnown(fit.T_map_vehicle)) return;
  Candidate candidate{.fits = std::vector<std::optional<ViewFit>>(views_.size())};
  candidate.fits.back() = FitAround(views_.back(), fit.T_map_vehicle, kOdometryBlur_m, workspace);
  const Pose3& T_map_vehicle = candidate.fits.back()->T_map_vehicle;
  // The search goes by whole blocks, and registration moves.
  if (region_ && !region_->Contains(Flatten(T_map_vehicle))) return;
  if (!IsKnown(T_map_vehicle)) candidates_.push_back(std::move(candidate));
}

template <int Dim>
bool GlobalLocalizer<Dim>::IsKnown(const Pose3& T_map_vehicle) const {
  return std::ranges::any_of(candidates_, [&](const Candidate& one) {
    return IsSamePlace(one.fits.back()->T_map_vehicle, T_map_vehicle);
  });
}

// Of a candidate that lacks one, beside one that is there.
template <int Dim>
bool GlobalLocalizer<Dim>::FillNextFit(RegistrationWorkspace<Dim>& workspace) {
  for (Candidate& candidate : candidates_) {
    std::vector<std::optional<ViewFit>>& fits = candidate.fits;
    const auto missing = std::ranges::adjacent_find(
        fits, [](const auto& a, const auto& b) { return a.has_value() != b.has_value(); });
    if (missing == fits.end()) continue;
    const auto i = static_cast<std::size_t>(missing - fits.begin());
    if (fits[i]) {
      fits[i + 1] = FitAfterMotion(views_[i + 1], *fits[i], views_[i + 1].motion, workspace);
    } else {
      fits[i] = FitAfterMotion(views_[i], *fits[i + 1], Reversed(views_[i + 1].motion), workspace);
    }
    return true;
  }
  return false;
}

// Places that explain the newest view so badly that the other views are not worth asking.
template <int Dim>
void GlobalLocalizer<Dim>::DropUnlikelyNewcomers() {
  constexpr double kHopeless = 4.0;
  double best = -std::numeric_limits<double>::infinity();
  for (const Candidate& one : candidates_) best = std::max(best, one.fits.back()->log_likelihood);
  std::erase_if(candidates_, [&](const Candidate& one) {
    return !one.fits.front() && one.fits.back()->log_likelihood < best - kHopeless;
  });
}

template <int Dim>
double GlobalLocalizer<Dim>::LogLikelihood(const Candidate& candidate) {
  double sum = 0.0;
  for (const std::optional<ViewFit>& fit : candidate.fits) sum += fit->log_likelihood;
  return sum;
}

// The most likely first.
template <int Dim>
void GlobalLocalizer<Dim>::KeepBestCandidates() {
  if (candidates_.empty()) return;
  constexpr double kHopeless = 10.0;
  std::ranges::stable_sort(candidates_, std::greater<>(), &GlobalLocalizer::LogLikelihood);
  std::erase_if(candidates_, [least = LogLikelihood(candidates_.front()) - kHopeless](
                                 const Candidate& one) { return LogLikelihood(one) < least; });
  if (candidates_.size() > kMaxKeptCandidates) candidates_.resize(kMaxKeptCandidates);
}

template <int Dim>
std::optional<Pose3> GlobalLocalizer<Dim>::Winner() const {
  if (views_.size() < 2 || candidates_.empty()) return std::nullopt;
  const Candidate& leader = candidates_.front();
  const Pose3& T_map_view = leader.fits.back()->T_map_vehicle;
  const bool is_acceptable =
      std::ranges::all_of(leader.fits, [](const auto& fit) { return fit->is_acceptable; });
  const double least = LogLikelihood(leader) - options_.min_lead;
  const bool stands_out = std::ranges::none_of(candidates_, [&](const Candidate& other) {
    return LogLikelihood(other) > least &&
           !IsSamePlace(other.fits.back()->T_map_vehicle, T_map_view);
  });
  if (!is_acceptable || !stands_out) return std::nullopt;
  return T_map_view;
}

template <int Dim>
typename GlobalLocalizer<Dim>::ViewFit GlobalLocalizer<Dim>::FitAfterMotion(
    const View& view, const ViewFit& beside, const Motion& motion,
    RegistrationWorkspace<Dim>& workspace) {
  const Pose3 T_map_expected = beside.T_map_vehicle * motion.T_from_to;
  ViewFit fit = FitAround(view, T_map_expected, kOdometryBlur_m, workspace);
  const PoseEstimate<Dim> apart =
      FromSpace<Dim>(T_map_expected.Inverse() * fit.T_map_vehicle, motion.covariance);
  fit.log_likelihood -= 0.5 * SquaredDistance<Dim>(apart.pose, apart.covariance);
  return fit;
}

template <int Dim>
typename GlobalLocalizer<Dim>::ViewFit GlobalLocalizer<Dim>::FitAround(
    const View& view, const Pose3& T_map_vehicle, double blur_m,
    RegistrationWorkspace<Dim>& workspace) {
  GicpOptions gicp = gicp_;
  gicp.max_iterations = 15;
  gicp.translation_tolerance_m = 0.005;
  gicp.rotation_tolerance_rad = 0.0005;
  gicp.initial_blur_m = blur_m;
  const auto registration = Register(view.live, T_map_vehicle, gicp, workspace);
  if (!registration) return {.T_map_vehicle = T_map_vehicle};
  return {.T_map_vehicle = InMap(registration->T_local_vehicle),
          .log_likelihood = kPerScore * registration->score,
          .is_acceptable = registration->inlier_count >= options_.gate.min_inlier_count &&
                           registration->overlap >= kViewShare * options_.gate.min_overlap &&
                           registration->residual_scale <= options_.gate.max_residual_scale};
}

// In the local map there, if there is one.
template <int Dim>
std::optional<Registration<Dim>> GlobalLocalizer<Dim>::Register(
    std::span<const GaussianPoint<Dim>> live, const Pose3& T_map_vehicle, const GicpOptions& gicp,
    RegistrationWorkspace<Dim>& workspace) {
  const std::optional<std::size_t> nearest =
      map_->NearestKeyframe(T_map_vehicle.translation_m, local_map_radius_m_);
  if (!nearest) return std::nullopt;
  if (nearest != keyframe_) {
    local_map_.MoveTo(*map_, T_map_vehicle.translation_m, local_map_radius_m_, workspace.local_map);
    keyframe_ = nearest;
  }
  const Pose3 T_local_vehicle = local_map_.T_map_local().Inverse() * T_map_vehicle;
  Registration<Dim> registration =
      RegisterGicp<Dim>(live, local_map_, FromSpace<Dim>(T_local_vehicle, Matrix6d::Zero()).pose,
                        gicp, workspace.finder);
  // Each step goes through all points, and the landmarks around each.
  constexpr double kLandmarks = 1000.0;
  work_ += static_cast<double>(live.size()) * (1 + registration.iterations) *
           (1.0 + static_cast<double>(local_map_.points().size()) / kLandmarks);
  return registration;
}

// A pose in the local map.
template <int Dim>
Pose3 GlobalLocalizer<Dim>::InMap(const Pose<Dim>& T_local_vehicle) const {
  return local_map_.T_map_local() *
         ToSpace<Dim>({.pose = T_local_vehicle}, UnobservedSigmas{}).pose;
}

template class GlobalLocalizer<2>;
template class GlobalLocalizer<3>;

}  // namespace dcloc
