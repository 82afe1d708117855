#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/degrees.h"
#include "core/localizer/localization_state.h"
#include "core/localizer/tracking_states.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"
#include "core/uncertainty/map_fit_monitor.h"
#include "core/uncertainty/place_evidence.h"

namespace dcloc {

/// When one mode changes to another.
struct TrackingOptions {
  int min_accepted_registrations = 3;  ///< accepted registrations in a row that start tracking
  /// Refused registrations in a row that drop a place which global localization has just found.
  int global_start_max_refusals = 3;
  /// Tracking lasts at least this long without an accepted registration.
  std::chrono::nanoseconds tracking_timeout = std::chrono::milliseconds(400);
  double hold_intervals = 2.5;  ///< and at least this many usual intervals of registrations
  /// A longer interval counts as this in the usual one.
  std::chrono::nanoseconds max_usual_interval = std::chrono::milliseconds(600);
  double interval_forgetting_factor = 0.8;  ///< weight of older intervals in the usual one, [0, 1)
  /// Scans in a row that must fit the map to end kSuspect; a registration must be accepted, too.
  int min_fitting_scans = 3;
  /// After so many scans in a row that do not fit, on ground that repeats, only global localization
  /// confirms the pose.
  int min_contradicting_scans = 3;
  // Poses less certain than these are not called tracking.
  double tracking_sigma_m = 1.0;                 ///< of the position
  double tracking_sigma_rad = 2.5 * kRadPerDeg;  ///< of the heading
  /// A pose is not called tracking once registrations have not observed the along-track position
  /// for this long, as in a smooth tunnel: odometry alone determines it there.
  std::chrono::nanoseconds max_unobserved = std::chrono::milliseconds(1500);
  /// After such a gap it must have been observed for this long: single registrations may seem to
  /// observe it by chance.
  std::chrono::nanoseconds min_observed = std::chrono::milliseconds(2000);
  /// Dead reckoning is lost after this time without an accepted registration. Radars that scan ten
  /// times a second so report it within a second.
  std::chrono::nanoseconds dead_reckoning_timeout = std::chrono::milliseconds(900);
  double lost_sigma_m = 2.0;  ///< dead reckoning less certain than this is lost at once
  /// A vehicle that is lost and less certain than `lost_sigma_m` for longer is searched for.
  std::chrono::nanoseconds lost_uncertain_timeout = std::chrono::milliseconds(1000);
  /// A vehicle that becomes lost to outliers twice within this time is searched for.
  std::chrono::nanoseconds contradiction_span = std::chrono::seconds(10);
  /// A vehicle whose unconfirmed prior has grown less certain than this is searched for. Searches
  /// around a prediction reach ten metres; of a wider one they could miss the truth.
  double max_prior_sigma_m = 4.5;
};
std::span<const OptionField<TrackingOptions>> FieldsOf(const TrackingOptions& options);
absl::Status Validate(const TrackingOptions& options);

/// What came of a registration: no pose fits the map, the one that fits is an outlier against the
/// estimate, or it is accepted.
enum class RegistrationOutcome { kNoMatch, kOutlier, kAccepted };

/// Why a pose is given up: registrations start from it no longer, and the map is searched.
enum class TrackingFailure {
  kNone,
  kPlaceRefused,  ///< the place found by global localization is refused by what followed
  kPriorTooWide,  ///< nothing has confirmed the prior, and it has grown beyond `max_prior_sigma_m`
  kUncertain,     ///< lost and less certain than `lost_sigma_m` for `lost_uncertain_timeout`
  /// Lost to outliers twice within `contradiction_span`. A burst of false registrations passes, and
  /// a step of true ones is followed; a pose at a wrong place is contradicted again and again.
  kContradicted,
};

/// What of a vehicle that has been tracked another state machine goes on from.
struct TrackingSnapshot {
  TrackingMode mode = TrackingMode::kDeadReckoning;
  ConfirmationRequirement confirmation_requires = ConfirmationRequirement::kRegistrations;
  AlongTrackObservability observability = AlongTrackObservability::kObserved;
  Stamp observability_changed{};
  Stamp last_accepted{};
  double usual_interval_s = 0.0;  ///< of registrations; 0: not known
  std::optional<Stamp> last_lost_to_outliers;
};

/// OK, or InvalidArgument that names what can be no snapshot of a vehicle that was tracked.
absl::Status Validate(const TrackingSnapshot& snapshot);

/// Decides what an answer claims of its pose. Nothing else decides whether it is TRACKING.
class TrackingStateMachine {
 public:
  explicit TrackingStateMachine(const TrackingOptions& options) : options_(options) {}

  TrackingMode mode() const { return mode_; }
  /// Whether there is a pose that registrations start from; else the map is searched.
  bool has_pose() const {
    return mode_ != TrackingMode::kSearching && mode_ != TrackingMode::kRecovering;
  }

  /// Whether the pose was not confirmed for so long that it may be anywhere.
  bool is_lost() const {
    return mode_ == TrackingMode::kLost || mode_ == TrackingMode::kContradicted;
  }

  /// Whether the pose is one of a prior, or of a search, that nothing has confirmed yet.
  bool is_to_be_confirmed() const {
    return mode_ == TrackingMode::kConfirmingPrior || mode_ == TrackingMode::kConfirmingPlace;
  }

  /// Starts from a prior; only in kSearching.
  void OnPrior() { mode_ = Next(mode_, TrackingEvent::kPriorGiven); }

  /// Whether global localization is to look for a better place beside the pose.
  bool ShouldSearchBeside() const {
    if (mode_ == TrackingMode::kConfirmingPlace) {
      return confirmation_requires_ !=
             ConfirmationRequirement::kRegistrations;  // fixes contradict this place, too
    }
    return has_pose() && mode_ != TrackingMode::kConfirmed;
  }

  /// Starts from a place that global localization found. What was counted before does not matter
  /// any more.
  void OnPlaceFound();

  /// No other place fits as well as the pose.
  void OnVerified();

  /// Fixes contradict the pose persistently: until they agree again, or the pose is verified, scans
  /// that fit do not make it confirmed.
  void OnFixesContradict();
  void OnFixAgrees() {
    confirmation_requires_ = Next(confirmation_requires_, ConfirmationEvent::kFixAgrees);
  }

  /// Takes in whether scan after scan fits less than it did, or another place better: ground that
  /// looks alike fits a little. Where it repeats, that the fit recovers says nothing: the next
  /// place that looks alike has come nearer.
  void OnFitTrend(FitTrend trend, bool ground_repeats = false);

  /// Whether only global localization can confirm the pose.
  bool requires_verification() const {
    return confirmation_requires_ == ConfirmationRequirement::kVerification;
  }

  /// Whether the pose is one from a prior that nothing speaks against yet.
  bool is_undoubted_prior() const {
    return mode_ == TrackingMode::kConfirmingPrior &&
           confirmation_requires_ == ConfirmationRequirement::kRegistrations;
  }

  /// Takes in how the newest scan fits the map, and whether one that does would fit nearby, too.
  void OnScanFit(ScanFit fit, bool ground_repeats = false);

  /// Takes in whether what is seen speaks for the place. While it does not, registrations count as
  /// if none had been accepted, and nothing is TRACKING before it does.
  void OnPlaceEvidence(EvidenceForPlace evidence) { evidence_ = evidence; }

  /// Ends by `stamp` what has lasted for too long without an accepted registration, or has become
  /// too uncertain: the estimate's position has this standard deviation. Without a pose nothing.
  void ExpireTimeouts(Stamp stamp, double position_sigma_m);

  /// Takes in whether the newest registration observed both horizontal directions. After a
  /// tunnel the pose must be verified: registrations would find a match wherever odometry put it.
  void OnObservability(Stamp stamp, bool is_observed);

  /// Takes in a registration's outcome at `stamp`.
  void OnRegistration(Stamp stamp, RegistrationOutcome outcome);

  /// Gives the pose up where it has failed by `stamp`: `has_pose()` is false afterwards. Otherwise
  /// kNone, and nothing changes. `position_sigma_m` is that of the estimate.
  TrackingFailure GiveUpIfFailed(Stamp stamp, double position_sigma_m);

  /// Where the vehicle has been tracked, its pose is not given up and something speaks for it; else
  /// nothing.
  std::optional<TrackingSnapshot> Snapshot() const;

  /// Restores a valid snapshot. What it counted in a row is counted anew: three registrations
  /// confirm the pose. Before the first event.
  void Restore(const TrackingSnapshot& snapshot);

  /// What to claim of a pose with these claimed sigmas (METHOD eq 57).
  LocalizationState Report(double claimed_position_sigma_m,
                           double claimed_heading_sigma_rad = 0.0) const;

 private:
  TrackingFailure FindFailure(Stamp stamp, double position_sigma_m) const;
  void Lose(Stamp stamp);
  void Confirm();
  std::chrono::nanoseconds Hold() const;
  void LearnInterval(Stamp stamp);

  TrackingOptions options_;
  TrackingMode mode_ = TrackingMode::kSearching;
  ScanAgreement agreement_ = ScanAgreement::kAgree;
  ConfirmationRequirement confirmation_requires_ = ConfirmationRequirement::kRegistrations;
  FitTrend fit_trend_ = FitTrend::kUsual;
  EvidenceForPlace evidence_ = EvidenceForPlace::kTooLittle;
  AlongTrackObservability observability_ = AlongTrackObservability::kObserved;
  Stamp observability_changed_{};  // when `observability_` last changed
  int accepted_in_a_row_ = 0;
  int refused_in_a_row_ = 0;
  int outliers_in_a_row_ = 0;
  int agreed_in_a_row_ = 0;        // scans, since the last one that contradicted
  int contradicted_in_a_row_ = 0;  // scans, since the last one that agreed
  std::optional<Stamp> last_registration_;
  double usual_interval_s_ = 0.0;
  std::optional<Stamp> last_accepted_;
  std::optional<Stamp> uncertain_since_;  // while lost: less certain than lost_sigma_m
  std::optional<Stamp> last_lost_to_outliers_;
};

}  // namespace dcloc
