#include "core/localizer/place_contest.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/covariance.h"
#include "core/localizer/planar_or_spatial.h"
#include "core/localizer/scratch.h"

namespace dcloc {
namespace {

constexpr std::size_t kMaxViews = 4;
constexpr std::size_t kMaxContenders = 32;
// Of a view's points so many tell places apart, and so many what is no place at all.
constexpr std::size_t kLookPoints = 400;
constexpr std::size_t kGlancePoints = 100;
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
std::vector<GaussianPoint<Dim>> EvenChoice(std::span<const GaussianPoint<Dim>> points,
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

template <int Dim>
void PlaceContest<Dim>::OnMotion(const Motion& motion) {
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
bool PlaceContest<Dim>::WantsView(Stamp stamp) const {
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
void PlaceContest<Dim>::AddView(Stamp stamp, std::span<const GaussianPoint<Dim>> live,
                                const std::optional<PlaceRegion>& region) {
  if (views_.size() == kMaxViews) {
    views_.erase(views_.begin());
    for (Candidate& candidate : candidates_) candidate.looks.erase(candidate.looks.begin());
  }
  views_.push_back({.live = EvenChoice(live, kLookPoints),
                    .few = EvenChoice(live, kGlancePoints),
                    .motion = std::exchange(since_view_, {}),
                    .way_m = std::exchange(since_view_m_, 0.0)});
  for (Candidate& candidate : candidates_) candidate.looks.emplace_back();
  view_stamp_ = stamp;
  ++view_count_;
  region_ = region;
  const bool is_little = region && region->radius_m <= kLittleGround_m;
  search_.emplace(map_, PositionsOf(live),
                  PlaceSearchOptions{.cell_m = is_little ? kLittleCell_m : kCell_m,
                                     .max_count = options_.match.blind_places,
                                     .region = region});
  phase_ = Phase::kCarryOn;
}

template <int Dim>
std::optional<Pose3> PlaceContest<Dim>::Continue() {
  work_ = 0.0;
  while (work_ < kMaxWork && phase_ != Phase::kIdle) DoNextPiece();
  if (!winner_ || Way() < options_.match.blind_distance_m) return std::nullopt;
  return *winner_ * since_view_.T_from_to;
}

// From the oldest view on.
template <int Dim>
double PlaceContest<Dim>::Way() const {
  double way_m = since_view_m_;
  for (std::size_t i = 1; i < views_.size(); ++i) way_m += views_[i].way_m;
  return way_m;
}

template <int Dim>
void PlaceContest<Dim>::Clear() {
  *this = PlaceContest(map_, options_);
}

template <int Dim>
void PlaceContest<Dim>::DoNextPiece() {
  switch (phase_) {
    case Phase::kCarryOn:
      if (!FillNextLook()) phase_ = Phase::kSearch;
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
      phase_ = Phase::kGlance;
      break;
    case Phase::kGlance:
      if (!places_.empty()) {
        GlanceAt(places_.back());
        places_.pop_back();
        break;
      }
      KeepPromising();
      phase_ = Phase::kLook;
      break;
    case Phase::kLook:
      if (!glances_.empty()) {
        LookAt(glances_.back());
        glances_.pop_back();
        break;
      }
      DropUnlikelyNewcomers();
      phase_ = Phase::kTraceBack;
      break;
    case Phase::kTraceBack:
      if (FillNextLook()) break;
      KeepContenders();
      winner_ = Winner();
      phase_ = Phase::kIdle;
      break;
    case Phase::kIdle:
      break;
  }
}

// Most places that a search finds are none: a few points and steps tell.
template <int Dim>
void PlaceContest<Dim>::GlanceAt(const PlaceHypothesis& place) {
  const Pose3 T_map_vehicle =
      map_->keyframe(place.keyframe).T_map_keyframe * Embed(place.T_keyframe_vehicle);
  if (IsKnown(T_map_vehicle)) return;
  GicpOptions gicp = options_.gicp;
  gicp.max_iterations = 8;
  gicp.translation_tolerance_m = 0.02;
  gicp.rotation_tolerance_rad = 0.002;
  // Half a step off in position and heading: about as much as a step.
  gicp.initial_blur_m = cell_m_;
  if (const auto registration = Register(views_.back().few, T_map_vehicle, gicp)) {
    glances_.push_back(
        {.T_map_vehicle = InMap(registration->T_local_vehicle), .score = registration->score});
  }
}

template <int Dim>
void PlaceContest<Dim>::KeepPromising() {
  constexpr double kHopeless = 0.2;
  double best = 0.0;
  for (const Glance& glance : glances_) best = std::max(best, glance.score);
  for (const Candidate& one : candidates_) {
    best = std::max(best, one.looks.back()->log_likelihood / kPerScore);
  }
  std::erase_if(glances_, [&](const Glance& glance) { return glance.score < best - kHopeless; });
  std::ranges::stable_sort(glances_, {}, &Glance::score);
}

// A place that no candidate has come to yet is a candidate of its own.
template <int Dim>
void PlaceContest<Dim>::LookAt(const Glance& glance) {
  if (IsKnown(glance.T_map_vehicle)) return;
  Candidate candidate{.looks = std::vector<std::optional<Look>>(views_.size())};
  candidate.looks.back() = LookAround(views_.back(), glance.T_map_vehicle, kOdometryBlur_m);
  const Pose3& T_map_vehicle = candidate.looks.back()->T_map_vehicle;
  // The search goes by whole blocks, and registration moves.
  if (region_ && !region_->Holds(Flatten(T_map_vehicle))) return;
  if (!IsKnown(T_map_vehicle)) candidates_.push_back(std::move(candidate));
}

template <int Dim>
bool PlaceContest<Dim>::IsKnown(const Pose3& T_map_vehicle) const {
  return std::ranges::any_of(candidates_, [&](const Candidate& one) {
    return IsSamePlace(one.looks.back()->T_map_vehicle, T_map_vehicle);
  });
}

// Of a candidate that lacks one, beside one that is there.
template <int Dim>
bool PlaceContest<Dim>::FillNextLook() {
  for (Candidate& candidate : candidates_) {
    std::vector<std::optional<Look>>& looks = candidate.looks;
    const auto missing = std::ranges::adjacent_find(
        looks, [](const auto& a, const auto& b) { return a.has_value() != b.has_value(); });
    if (missing == looks.end()) continue;
    const auto i = static_cast<std::size_t>(missing - looks.begin());
    if (looks[i]) {
      looks[i + 1] = LookAfter(views_[i + 1], *looks[i], views_[i + 1].motion);
    } else {
      looks[i] = LookAfter(views_[i], *looks[i + 1], Reversed(views_[i + 1].motion));
    }
    return true;
  }
  return false;
}

// Places that explain the newest view so badly that the other views are not worth asking.
template <int Dim>
void PlaceContest<Dim>::DropUnlikelyNewcomers() {
  constexpr double kHopeless = 4.0;
  double best = -std::numeric_limits<double>::infinity();
  for (const Candidate& one : candidates_) best = std::max(best, one.looks.back()->log_likelihood);
  std::erase_if(candidates_, [&](const Candidate& one) {
    return !one.looks.front() && one.looks.back()->log_likelihood < best - kHopeless;
  });
}

template <int Dim>
double PlaceContest<Dim>::LogLikelihood(const Candidate& candidate) {
  double sum = 0.0;
  for (const std::optional<Look>& look : candidate.looks) sum += look->log_likelihood;
  return sum;
}

// The most likely first.
template <int Dim>
void PlaceContest<Dim>::KeepContenders() {
  if (candidates_.empty()) return;
  constexpr double kHopeless = 10.0;
  std::ranges::stable_sort(candidates_, std::greater<>(), &PlaceContest::LogLikelihood);
  std::erase_if(candidates_, [least = LogLikelihood(candidates_.front()) - kHopeless](
                                 const Candidate& one) { return LogLikelihood(one) < least; });
  if (candidates_.size() > kMaxContenders) candidates_.resize(kMaxContenders);
}

template <int Dim>
std::optional<Pose3> PlaceContest<Dim>::Winner() const {
  if (views_.size() < 2 || candidates_.empty()) return std::nullopt;
  const Candidate& leader = candidates_.front();
  const Pose3& T_map_view = leader.looks.back()->T_map_vehicle;
  const bool is_believable =
      std::ranges::all_of(leader.looks, [](const auto& look) { return look->is_believable; });
  const double least = LogLikelihood(leader) - options_.match.blind_min_lead;
  const bool stands_out = std::ranges::none_of(candidates_, [&](const Candidate& other) {
    return LogLikelihood(other) > least &&
           !IsSamePlace(other.looks.back()->T_map_vehicle, T_map_view);
  });
  if (!is_believable || !stands_out) return std::nullopt;
  return T_map_view;
}

template <int Dim>
typename PlaceContest<Dim>::Look PlaceContest<Dim>::LookAfter(const View& view, const Look& beside,
                                                              const Motion& motion) {
  const Pose3 T_map_expected = beside.T_map_vehicle * motion.T_from_to;
  Look look = LookAround(view, T_map_expected, kOdometryBlur_m);
  const PoseEstimate<Dim> apart =
      FromSpace<Dim>(T_map_expected.Inverse() * look.T_map_vehicle, motion.covariance);
  look.log_likelihood -= 0.5 * SquaredDistance<Dim>(apart.pose, apart.covariance);
  return look;
}

template <int Dim>
typename PlaceContest<Dim>::Look PlaceContest<Dim>::LookAround(const View& view,
                                                               const Pose3& T_map_vehicle,
                                                               double blur_m) {
  const MatchOptions& match = options_.match;
  GicpOptions gicp = options_.gicp;
  gicp.max_iterations = 15;
  gicp.translation_tolerance_m = 0.005;
  gicp.rotation_tolerance_rad = 0.0005;
  gicp.initial_blur_m = blur_m;
  const auto registration = Register(view.live, T_map_vehicle, gicp);
  if (!registration) return {.T_map_vehicle = T_map_vehicle};
  return {.T_map_vehicle = InMap(registration->T_local_vehicle),
          .log_likelihood = kPerScore * registration->score,
          .is_believable = registration->inlier_count >= match.blind_min_inlier_count &&
                           registration->overlap >= kViewShare * match.blind_min_overlap &&
                           registration->residual_scale <= match.max_residual_scale};
}

// In the local map there, if there is one.
template <int Dim>
std::optional<Registration<Dim>> PlaceContest<Dim>::Register(
    std::span<const GaussianPoint<Dim>> live, const Pose3& T_map_vehicle, const GicpOptions& gicp) {
  const double radius_m = options_.match.local_map_radius_m;
  const std::optional<std::size_t> nearest =
      map_->NearestKeyframe(T_map_vehicle.translation_m, radius_m);
  if (!nearest) return std::nullopt;
  Scratch<Dim>& scratch = Scratch<Dim>::OfThisThread();
  if (nearest != keyframe_) {
    local_map_.MoveTo(*map_, T_map_vehicle.translation_m, radius_m, scratch.local_map);
    keyframe_ = nearest;
  }
  const Pose3 T_local_vehicle = local_map_.T_map_local().Inverse() * T_map_vehicle;
  Registration<Dim> registration =
      RegisterGicp<Dim>(live, local_map_, FromSpace<Dim>(T_local_vehicle, Matrix6d::Zero()).pose,
                        gicp, scratch.finder);
  // Each step goes through all points, and the landmarks around each.
  constexpr double kLandmarks = 1000.0;
  work_ += static_cast<double>(live.size()) * (1 + registration.iterations) *
           (1.0 + static_cast<double>(local_map_.points().size()) / kLandmarks);
  return registration;
}

// A pose in the local map.
template <int Dim>
Pose3 PlaceContest<Dim>::InMap(const Pose<Dim>& T_local_vehicle) const {
  return local_map_.T_map_local() * ToSpace<Dim>({.pose = T_local_vehicle}, options_).pose;
}

template class PlaceContest<2>;
template class PlaceContest<3>;

}  // namespace dcloc
