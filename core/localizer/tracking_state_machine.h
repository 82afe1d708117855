#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/localizer/localization_state.h"
#include "core/localizer/tracking_states.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"
#include "core/uncertainty/map_fit_monitor.h"

namespace dcloc {

/// When one mode changes to another.
struct TrackingOptions {
  int confirmations = 3;  ///< accepted registrations in a row that start tracking
  /// After global localization, refused registrations in a row that drop the place it found.
  int global_start_max_refusals = 3;
  /// Tracking lasts so long without an accepted registration, or so many intervals of
  /// registrations as they are usual, of which each is at most `max_usual_interval`.
  std::chrono::nanoseconds tracking_hold = std::chrono::milliseconds(400);
  double hold_intervals = 2.5;
  std::chrono::nanoseconds max_usual_interval = std::chrono::milliseconds(600);
  double interval_memory = 0.8;  ///< the weight of older intervals in the usual one
  /// Scans in a row that fit the map as they should end a doubt.
  int agreements = 3;
  double tracking_sigma_m = 1.0;  ///< poses less certain than this are not called tracking
  /// Nor are those of a vehicle that has not observed its way for so long, as in a smooth tunnel:
  /// where it is there, odometry alone says.
  std::chrono::nanoseconds max_unobserved = std::chrono::milliseconds(1500);
  /// What has been observed for less long may be chance.
  std::chrono::nanoseconds min_observed = std::chrono::milliseconds(2000);
  /// Without an accepted registration for so long, or less certain than `lost_sigma_m`, dead
  /// reckoning is lost. Radars that scan ten times a second so report it within a second.
  std::chrono::nanoseconds lost_after = std::chrono::milliseconds(900);
  double lost_sigma_m = 2.0;
  /// A vehicle that is lost and less certain than `lost_sigma_m` for so long is searched for.
  std::chrono::nanoseconds lost_hold = std::chrono::milliseconds(1000);
  /// A vehicle that becomes lost to outliers twice within so long is searched for.
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

/// Why a pose is given up.
enum class Loss {
  kNone,
  kPlaceRefused,  ///< the place found by global localization is refused by what followed
  kPriorTooWide,  ///< nothing has confirmed the prior, and it has grown beyond `max_prior_sigma_m`
  kUncertain,     ///< lost and less certain than `lost_sigma_m` for `lost_hold`
  /// Lost to outliers twice within `contradiction_span`. A burst of false registrations passes, and
  /// a step of true ones is followed; a pose at a wrong place is contradicted again and again.
  kContradicted,
};

/// What of a vehicle that has been tracked another state machine goes on from.
struct TrackingSnapshot {
  TrackingMode mode = TrackingMode::kDeadReckoning;
  Verification verification = Verification::kNotNeeded;
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
  bool is_lost() const { return mode_ == TrackingMode::kLost || mode_ == TrackingMode::kLostTwice; }

  /// Starts from a prior; only in kSearching.
  void OnPrior() { mode_ = Next(mode_, TrackingEvent::kPriorGiven); }

  /// Whether the pose that there is must be held against other places.
  bool needs_verification() const {
    if (mode_ == TrackingMode::kConfirmingPlace) {
      return verification_ != Verification::kNotNeeded;  // something contradicts this place, too
    }
    return has_pose() && mode_ != TrackingMode::kConfirmed;
  }

  /// Whether the pose is one from a prior that nothing speaks against yet.
  bool is_trusted_prior() const {
    return mode_ == TrackingMode::kConfirmingPrior && verification_ == Verification::kNotNeeded;
  }

  /// Starts from a place that global localization found. What was counted before does not matter
  /// any more.
  void OnPlaceFound();

  /// No other place fits as well as the pose.
  void OnVerified();

  /// Fixes contradict the pose persistently: until they agree again, or the pose is verified, scans
  /// that fit do not make it confirmed.
  void OnFixesContradict();
  void OnFixAgrees() { verification_ = Next(verification_, VerificationEvent::kFixAgrees); }

  /// Takes in how the newest scan fits the map.
  void OnScanFit(ScanFit fit);

  /// Scans fit another place better than the pose: it must be verified.
  void OnRivalFits();

  /// Takes in the time and the position's standard deviation of a predicted pose; without a pose
  /// nothing.
  void OnPrediction(Stamp stamp, double position_sigma_m);

  /// Takes in whether the newest registration observed both horizontal directions. A vehicle that
  /// comes out of a tunnel must be verified: registrations would fit it in where odometry says.
  void OnObservability(Stamp stamp, bool is_observed);

  /// Takes in a registration's outcome at `stamp`.
  void OnRegistration(Stamp stamp, RegistrationOutcome outcome);

  /// Whether the pose, as uncertain as said, is to be given up at `stamp`; then it is: `has_pose()`
  /// is false afterwards.
  Loss GiveUpIfLost(Stamp stamp, double position_sigma_m);

  /// Where the vehicle has been tracked and its pose is not given up; else nothing.
  std::optional<TrackingSnapshot> Snapshot() const;

  /// Goes on from a valid snapshot. What it counted in a row is counted anew: three registrations
  /// confirm the pose. Before the first event.
  void GoOnFrom(const TrackingSnapshot& snapshot);

  /// What to claim of a pose whose position has this standard deviation.
  LocalizationState Report(double position_sigma_m) const;

 private:
  Loss FindLoss(Stamp stamp, double position_sigma_m) const;
  void Lose(Stamp stamp);
  void Confirm();
  std::chrono::nanoseconds Hold() const;
  void LearnInterval(Stamp stamp);

  TrackingOptions options_;
  TrackingMode mode_ = TrackingMode::kSearching;
  ScanAgreement agreement_ = ScanAgreement::kAgree;
  Verification verification_ = Verification::kNotNeeded;
  AlongTrackObservability observability_ = AlongTrackObservability::kObserved;
  Stamp observability_changed_{};  // when registrations began to observe the way, or not to
  int accepted_in_a_row_ = 0;
  int refused_in_a_row_ = 0;
  int outliers_in_a_row_ = 0;
  int agreed_in_a_row_ = 0;  // scans, since the last one that contradicted
  std::optional<Stamp> last_registration_;
  double usual_interval_s_ = 0.0;
  std::optional<Stamp> last_accepted_;
  std::optional<Stamp> uncertain_since_;  // while lost: less certain than lost_sigma_m
  std::optional<Stamp> last_lost_to_outliers_;
};

}  // namespace dcloc
