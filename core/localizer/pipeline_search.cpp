// When the map is searched for the vehicle, and what follows where the pose has failed.
#include "core/geometry/covariance.h"
#include "core/geometry/pose_estimate.h"
#include "core/localizer/pipeline.h"

namespace dcloc {

// Where there is no pose, or one that may be wrong.
template <int Dim>
std::optional<typename Pipeline<Dim>::Place> Pipeline<Dim>::SearchPlace(
    std::span<const GaussianPoint<Dim>> live, Stamp stamp, RegistrationWorkspace<Dim>& workspace) {
  using Basis = typename GlobalLocalizer<Dim>::Basis;
  std::optional<typename Relocalizer<Dim>::ExpectedPlace> expected;
  if (tracking_.has_pose()) {
    if (!tracking_.ShouldSearchBeside()) return std::nullopt;
    if (radars_.scan_checker.IsTooSoonToJudge(stamp, live_.submap.span())) return std::nullopt;
    const bool is_prior = tracking_.is_undoubted_prior();
    const bool is_held_widely = is_prior || tracking_.requires_verification();
    expected = {.T_map_vehicle = NowInMap().pose,
                .basis = is_prior ? Basis::kPrior : Basis::kSuspect,
                .min_radius_m = is_held_widely ? options_.prior.max_region_radius_m : 0.0};
    if (!relocalizer_.prior()) relocalizer_.SetPrior(NowInMap());
  }
  const int failed_count = relocalizer_.failed_search_count();
  std::optional<Place> place =
      relocalizer_.Search(stamp, live, live_.schedule.SinceBegin(), expected, workspace);
  if (place) radars_.range_trial.reset();
  if (relocalizer_.failed_search_count() > failed_count) OnSearchedInVain(stamp);
  return place;
}

// At a wrong pose chance decides what is learned of the radars, and with that nothing fits
// anywhere. So either is tried in turn. Biases of ranges are tried for longer and longer, as a
// search takes several views. Where nothing was ever learned, a guess has less time than what is
// described: where ranges are right, too, a place may be found late, and then fits a guess as well.
template <int Dim>
void Pipeline<Dim>::OnSearchedInVain(Stamp stamp) {
  constexpr int kGuessesBefore = 10;  // so many times as long as a guess before the first one
  TryOtherAzimuthSigns();
  std::optional<RangeTrial>& trial = radars_.range_trial;
  if (trial && stamp < trial->end) return;
  const bool guesses = radars_.range_biases.KnowsNothing() && relocalizer_.prior();
  if (guesses) {
    const bool begins = !trial;
    if (begins) {
      const std::chrono::nanoseconds before = kGuessesBefore * options_.range_guess;
      trial = {.duration = before, .end = stamp + before};
    }
    const auto has_guess = [&] { return radars_.range_biases.bias_m(0).has_value(); };
    if (begins && !has_guess()) return;  // one that a place was found with, in vain, goes
    GuessRangeBiases();
    if (has_guess()) {
      trial->end = stamp + options_.range_guess;
      return;
    }
  }
  const std::chrono::nanoseconds duration = trial ? 2 * trial->duration : options_.range_trial;
  trial = {.duration = duration, .end = stamp + duration};
  if (!guesses) TryOtherRangeBiases();
}

// No other place fits as well as the pose: neither scans nor fixes contradict it any longer. Where
// the ground fits less than it did, scans are judged by what it is like here.
template <int Dim>
void Pipeline<Dim>::OnPoseVerified(bool fits_as_usual) {
  tracking_.OnVerified();
  if (fits_as_usual) {
    radars_.scan_checker.OnConfirmed();
    place_evidence_.OnVerified(NowInMap().pose.translation_m.template head<2>());
  } else {
    radars_.scan_checker.Reset();
  }
  rivals_.Reset();
  fix_monitor_.OnRefuted();
}

// A pose that is given up becomes the prior of the search, unless it is a place that was refused.
template <int Dim>
void Pipeline<Dim>::GiveUpFailedPose(Stamp stamp) {
  if (!tracking_.has_pose()) return;
  PoseEstimate<3> now = ToSpace<Dim>(pose_.Now(), options_.unobserved);
  const TrackingFailure failure = tracking_.GiveUpIfFailed(stamp, HorizontalSigma(now.covariance));
  if (failure == TrackingFailure::kNone) return;
  if (radars_.range_rate_errors.OnLost()) ego_motion_.OnRangeRatesCorrected();
  if (failure == TrackingFailure::kContradicted) {
    now.covariance.diagonal() += ContradictedVariances(options_);
    // Scale, bias and noise were learned from poses at a wrong place.
    ego_motion_.ResetErrors();
    pose_.ResetNoise();
  }
  if (failure != TrackingFailure::kPlaceRefused) {
    now.pose = map_.matcher.T_map_local() * now.pose;
    relocalizer_.SetPrior(now);
  }
  pose_.Clear();
}

template std::optional<Pipeline<2>::Place> Pipeline<2>::SearchPlace(
    std::span<const GaussianPoint<2>>, Stamp, RegistrationWorkspace<2>&);
template std::optional<Pipeline<3>::Place> Pipeline<3>::SearchPlace(
    std::span<const GaussianPoint<3>>, Stamp, RegistrationWorkspace<3>&);
template void Pipeline<2>::OnPoseVerified(bool);
template void Pipeline<3>::OnPoseVerified(bool);
template void Pipeline<2>::GiveUpFailedPose(Stamp);
template void Pipeline<3>::GiveUpFailedPose(Stamp);

}  // namespace dcloc
