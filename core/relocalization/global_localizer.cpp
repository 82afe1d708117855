#include "core/relocalization/global_localizer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include "core/geometry/covariance.h"
#include "core/geometry/thinning.h"

namespace dcloc {
namespace {

// Most places that a search finds are wrong: a few steps show it.
constexpr RegistrationEffort kCoarseEffort{
    .max_iterations = 8, .translation_tolerance_m = 0.02, .rotation_tolerance_rad = 0.002};
// What is usual in the map of another street is 0.05, by chance; in the right one 0.4 to 0.5.
constexpr double kLeastScoreOfRightMap = 0.2;
constexpr double kSearchPieceWork = 24e3;  // of a piece of a search, about a millisecond

}  // namespace

template <int Dim>
void GlobalLocalizer<Dim>::OnMotion(const Motion& motion, const Matrix6d& spread) {
  if (views_.empty()) return;
  since_view_ = Compose(since_view_, motion);
  noise_since_view_ = Compose(
      noise_since_view_, {.T_from_to = motion.T_from_to, .covariance = motion.covariance - spread});
  travelled_since_view_m_ += motion.T_from_to.translation_m.norm();
  // Views that odometry does not join any more.
  const Matrix6d& covariance = noise_since_view_.covariance;
  if (HorizontalSigma(covariance) > options_.max_view_sigma_m ||
      std::sqrt(covariance(5, 5)) > options_.max_view_sigma_rad) {
    RetakeViews();
  }
}

template <int Dim>
void GlobalLocalizer<Dim>::RetakeViews() {
  const int view_count = view_count_;
  const int failed_search_count = failed_search_count_;
  Clear();
  view_count_ = view_count;  // the search for it goes on
  failed_search_count_ = failed_search_count;
}

// Views share scans where they follow one another sooner than a sub-map is long, so that a short
// distance is enough between two of them; the place that wins must hold over more.
template <int Dim>
bool GlobalLocalizer<Dim>::WantsView(Stamp stamp) const {
  if (phase_ != Phase::kIdle || winner_) return false;
  if (views_.empty()) return true;
  if (stamp - view_stamp_ < ViewInterval()) return false;
  // An expected place waits until the region around it has grown to the map, also where it stands.
  return (expected_ && region_) || travelled_since_view_m_ >= options_.view_distance_m;
}

// A vehicle outside of the map must not search it all the time. Where the newest view fits, it may
// have come in. Who never knew a place finds a wrong one sooner, as any score will do: there, views
// must lie further apart.
template <int Dim>
std::chrono::nanoseconds GlobalLocalizer<Dim>::ViewInterval() const {
  if (view_count_ < options_.early_view_count) return options_.view_interval;
  if (!newest_fits_) return options_.late_view_interval_factor * options_.view_interval;
  const bool knew_a_place = min_convincing_score_ > 0.0;
  return knew_a_place ? options_.view_interval
                      : options_.entering_view_interval_factor * options_.view_interval;
}

template <int Dim>
void GlobalLocalizer<Dim>::AddView(Stamp stamp, std::span<const GaussianPoint<Dim>> live,
                                   const std::optional<SearchRegion>& region,
                                   const std::optional<ExpectedPlace>& expected,
                                   double min_convincing_score) {
  if (views_.size() == static_cast<std::size_t>(options_.max_view_count)) DropOldestView();
  views_.push_back({.fine_points = EvenSubsample(live, options_.fine_point_count),
                    .coarse_points = EvenSubsample(live, options_.coarse_point_count),
                    .motion = std::exchange(since_view_, {}),
                    .travelled_m = std::exchange(travelled_since_view_m_, 0.0)});
  noise_since_view_ = {};
  for (Candidate& candidate : candidates_) candidate.fits.emplace_back();
  view_stamp_ = stamp;
  ++view_count_;
  region_ = region;
  expected_ = expected;
  min_convincing_score_ = min_convincing_score;
  const bool is_small = region && region->radius_m <= options_.small_region_radius_m;
  search_.emplace(
      map_, PositionsOf(live),
      PlaceSearchOptions{.cell_m = is_small ? options_.small_region_cell_m : options_.cell_m,
                         .max_count = options_.candidate_count,
                         .region = region});
  phase_ = Phase::kExtend;
}

template <int Dim>
void GlobalLocalizer<Dim>::DropOldestView() {
  views_.erase(views_.begin());
  for (Candidate& candidate : candidates_) candidate.fits.erase(candidate.fits.begin());
}

template <int Dim>
std::optional<typename GlobalLocalizer<Dim>::Place> GlobalLocalizer<Dim>::Continue(
    RegistrationWorkspace<Dim>& workspace) {
  work_ = 0.0;
  while (work_ < options_.max_work && phase_ != Phase::kIdle) DoNextPiece(workspace);
  const bool is_found = winner_ && winner_->origin == PlaceOrigin::kFound;
  if (!winner_ || (is_found && DistanceTravelled() < options_.min_distance_m)) return std::nullopt;
  return Place{winner_->T_map_vehicle * since_view_.T_from_to, winner_->origin,
               winner_->fits_as_usual};
}

// From the oldest view on.
template <int Dim>
double GlobalLocalizer<Dim>::DistanceTravelled() const {
  double travelled_m = travelled_since_view_m_;
  for (std::size_t i = 1; i < views_.size(); ++i) travelled_m += views_[i].travelled_m;
  return travelled_m;
}

template <int Dim>
void GlobalLocalizer<Dim>::Clear() {
  *this = GlobalLocalizer(map_, method_, local_map_radius_m_, options_);
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
        work_ += kSearchPieceWork;
        break;
      }
      EndSearch();
      AddExpected(workspace);
      phase_ = Phase::kCoarseFit;
      break;
    case Phase::kCoarseFit:
      if (!places_.empty()) {
        FitCoarsely(places_.back(), workspace);
        places_.pop_back();
        break;
      }
      KeepPromisingFits();
      phase_ = Phase::kFineFit;
      break;
    case Phase::kFineFit:
      if (!coarse_fits_.empty()) {
        FitFinely(coarse_fits_.back(), workspace);
        coarse_fits_.pop_back();
        break;
      }
      DropUnlikelyNewCandidates();
      phase_ = Phase::kBackfill;
      break;
    case Phase::kBackfill:
      if (FillNextFit(workspace)) break;
      newest_fits_ = FitsSomewhere(views_.size() - 1, &ViewFit::is_close);
      DropViewsOfElsewhere();
      KeepBestCandidates();
      winner_ = Winner();
      if (IsInVain()) ++failed_search_count_;
      phase_ = Phase::kIdle;
      break;
    case Phase::kIdle:
      break;
  }
}

template <int Dim>
void GlobalLocalizer<Dim>::EndSearch() {
  cell_m_ = search_->cell_m();
  places_ = search_->Best();
  std::ranges::reverse(places_);
  search_.reset();
}

template <int Dim>
void GlobalLocalizer<Dim>::FitCoarsely(const PlaceCandidate& place,
                                       RegistrationWorkspace<Dim>& workspace) {
  const Pose3 T_map_vehicle =
      map_->keyframe(place.keyframe).T_map_keyframe * Embed(place.T_keyframe_vehicle);
  if (IsKnown(T_map_vehicle)) return;
  // Half a step off in position and heading: about as much as a step.
  const auto found = registrar_.Register(views_.back().coarse_points, T_map_vehicle, cell_m_,
                                         kCoarseEffort, workspace);
  if (!found) return;
  work_ += found->work;
  coarse_fits_.push_back(
      {.T_map_vehicle = found->T_map_vehicle, .score = found->registration.score});
}

template <int Dim>
void GlobalLocalizer<Dim>::KeepPromisingFits() {
  double best = 0.0;
  for (const CoarseFit& fit : coarse_fits_) best = std::max(best, fit.score);
  for (const Candidate& one : candidates_) {
    best = std::max(best, one.fits.back()->log_likelihood / options_.log_likelihood_per_score);
  }
  std::erase_if(coarse_fits_, [&](const CoarseFit& fit) {
    return fit.score < best - options_.coarse_score_margin;
  });
  std::ranges::stable_sort(coarse_fits_, {}, &CoarseFit::score);
}

// A place that is no candidate's yet is a candidate of its own.
template <int Dim>
void GlobalLocalizer<Dim>::FitFinely(const CoarseFit& fit, RegistrationWorkspace<Dim>& workspace) {
  if (IsKnown(fit.T_map_vehicle)) return;
  Candidate candidate{.fits = std::vector<std::optional<ViewFit>>(views_.size())};
  candidate.fits.back() = FitAround(views_.back(), fit.T_map_vehicle, workspace);
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
      fits[i] = FitAfterMotion(views_[i], *fits[i + 1], Inverse(views_[i + 1].motion), workspace);
    }
    return true;
  }
  return false;
}

// Places that fit the newest view so badly that the other views need not be registered.
template <int Dim>
void GlobalLocalizer<Dim>::DropUnlikelyNewCandidates() {
  double best = -std::numeric_limits<double>::infinity();
  for (const Candidate& one : candidates_) best = std::max(best, one.fits.back()->log_likelihood);
  std::erase_if(candidates_, [&](const Candidate& one) {
    return !one.fits.front() && !one.is_expected &&
           one.fits.back()->log_likelihood < best - options_.new_candidate_margin;
  });
}

template <int Dim>
double GlobalLocalizer<Dim>::LogLikelihood(const Candidate& candidate) {
  double sum = 0.0;
  for (const std::optional<ViewFit>& fit : candidate.fits) sum += fit->log_likelihood;
  return sum;
}

template <int Dim>
bool GlobalLocalizer<Dim>::FitsSomewhere(std::size_t view, bool ViewFit::*quality) const {
  return std::ranges::any_of(candidates_,
                             [&](const Candidate& one) { return (*one.fits[view]).*quality; });
}

// What nothing in the map looks like says nothing of where the vehicle is, once something fits as
// scans did where it surely was: it was taken outside of the map, or by radars that were disturbed.
// The search begins anew. A prior waits for all views. In the map of another street much fits as
// badly as is usual there.
template <int Dim>
void GlobalLocalizer<Dim>::DropViewsOfElsewhere() {
  if (expected_ && expected_->basis == Basis::kPrior) return;
  if (min_convincing_score_ < kLeastScoreOfRightMap) return;
  if (!FitsSomewhere(views_.size() - 1, &ViewFit::is_as_usual)) return;
  while (views_.size() > 1 && !FitsSomewhere(0, &ViewFit::is_acceptable)) {
    DropOldestView();
    view_count_ = static_cast<int>(views_.size());
  }
}

// The place that is expected is a candidate, whether it was one before or not.
template <int Dim>
void GlobalLocalizer<Dim>::AddExpected(RegistrationWorkspace<Dim>& workspace) {
  for (Candidate& one : candidates_) one.is_expected = false;
  if (!expected_) return;
  const ViewFit fit = FitAround(views_.back(), expected_->T_map_vehicle, workspace);
  // What is doubted must be right as it is, and not some metres from there.
  if (expected_->basis == Basis::kSuspect &&
      !IsSamePlace(fit.T_map_vehicle, expected_->T_map_vehicle)) {
    return;
  }
  const auto same = std::ranges::find_if(candidates_, [&](const Candidate& one) {
    return IsSamePlace(one.fits.back()->T_map_vehicle, fit.T_map_vehicle);
  });
  if (same != candidates_.end()) {
    same->is_expected = true;
    return;
  }
  Candidate candidate{.fits = std::vector<std::optional<ViewFit>>(views_.size()),
                      .is_expected = true};
  candidate.fits.back() = fit;
  candidates_.push_back(std::move(candidate));
}

// The most likely first.
template <int Dim>
void GlobalLocalizer<Dim>::KeepBestCandidates() {
  if (candidates_.empty()) return;
  std::ranges::stable_sort(candidates_, std::greater<>(), &GlobalLocalizer::LogLikelihood);
  std::erase_if(candidates_, [least = LogLikelihood(candidates_.front()) -
                                      options_.candidate_margin](const Candidate& one) {
    return !one.is_expected && LogLikelihood(one) < least;
  });
  // The expected place is kept however unlikely it is.
  const auto max_count = static_cast<std::ptrdiff_t>(options_.max_kept_candidates);
  if (std::ssize(candidates_) <= max_count) return;
  const auto last_kept = candidates_.begin() + max_count - 1;
  const auto expected =
      std::find_if(std::next(last_kept), candidates_.end(), std::mem_fn(&Candidate::is_expected));
  if (expected != candidates_.end()) std::iter_swap(last_kept, expected);
  candidates_.erase(std::next(last_kept), candidates_.end());
}

template <int Dim>
bool GlobalLocalizer<Dim>::HoldsInAll(bool ViewFit::*quality, const Candidate& candidate) {
  return std::ranges::all_of(candidate.fits, [&](const auto& fit) { return (*fit).*quality; });
}

template <int Dim>
bool GlobalLocalizer<Dim>::StandsOut(const Candidate& candidate) const {
  const double least = LogLikelihood(candidate) - options_.min_lead;
  return std::ranges::none_of(candidates_, [&](const Candidate& other) {
    return LogLikelihood(other) > least &&
           !IsSamePlace(other.fits.back()->T_map_vehicle, candidate.fits.back()->T_map_vehicle);
  });
}

// METHOD eq 52. A prior is believed at once where nothing is better, and against better places only
// once all views were taken. A place that fits less well is right only where the whole map has
// nothing as good.
template <int Dim>
bool GlobalLocalizer<Dim>::IsExpectedRight(const Candidate& expected) const {
  if (region_ && !HoldsInAll(&ViewFit::is_convincing, expected)) return false;
  const bool is_prior = expected_->basis == Basis::kPrior;
  if (!HoldsInAll(&ViewFit::is_acceptable, expected)) {
    const bool stands_up = is_prior || (views_.size() >= 2 && StandsOut(expected));
    if (!stands_up || !expected.fits.back()->is_plausible) return false;
  }
  const bool has_all_views = views_.size() == static_cast<std::size_t>(options_.max_view_count);
  const double lead = is_prior && has_all_views ? options_.prior_lead : 0.0;
  return LogLikelihood(expected) + lead >= LogLikelihood(candidates_.front());
}

// METHOD eq 38. A place that nothing was known of must stand out in several views.
template <int Dim>
std::optional<typename GlobalLocalizer<Dim>::Place> GlobalLocalizer<Dim>::Winner() const {
  if (candidates_.empty()) return std::nullopt;
  const auto expected = std::ranges::find_if(candidates_, &Candidate::is_expected);
  if (expected != candidates_.end() && IsExpectedRight(*expected)) {
    return Place{expected->fits.back()->T_map_vehicle, PlaceOrigin::kExpected,
                 HoldsInAll(&ViewFit::is_as_usual, *expected)};
  }
  const Candidate& leader = candidates_.front();
  if (views_.size() < 2 || !HoldsInAll(&ViewFit::is_acceptable, leader) || !StandsOut(leader))
    return std::nullopt;
  if (expected_ && region_ && !HoldsInAll(&ViewFit::is_convincing, leader)) return std::nullopt;
  return Place{leader.fits.back()->T_map_vehicle,
               leader.is_expected ? PlaceOrigin::kExpected : PlaceOrigin::kFound,
               HoldsInAll(&ViewFit::is_as_usual, leader)};
}

// Nothing fits where was searched, so the vehicle is not there. A place that stands out must hold
// over some distance; one that is expected, and those around it, need not.
template <int Dim>
bool GlobalLocalizer<Dim>::IsInVain() const {
  if (winner_) return false;
  if (expected_)
    return candidates_.empty() || !HoldsInAll(&ViewFit::is_convincing, candidates_.front());
  return views_.size() >= 2 && DistanceTravelled() >= options_.min_distance_m &&
         (candidates_.empty() || !HoldsInAll(&ViewFit::is_acceptable, candidates_.front()));
}

template class GlobalLocalizer<2>;
template class GlobalLocalizer<3>;

}  // namespace dcloc
