#pragma once

#include <array>

#include "core/localizer/transition.h"

/// The states of TrackingStateMachine, as tables of arrows: the mode, and three kinds of evidence
/// that are kept beside it in every mode. An answer's state follows from the mode, from
/// AlongTrackObservability and from the position's sigma. STATES.md draws them.
namespace dcloc {

enum class TrackingMode {
  kSearching,        ///< no pose: global localization from nothing or from a vague prior
  kConfirmingPrior,  ///< a pose from a prior that was not yet held against other places
  kConfirmingPlace,  ///< a pose from global localization that must be confirmed
  kConfirmed,        ///< a pose that registrations have confirmed; TRACKING, if it is certain too
  kSuspect,          ///< a pose that was confirmed, but scans or fixes now contradict it
  kDeadReckoning,    ///< a pose carried by ego-motion, confirmed a moment ago
  kLost,             ///< a pose carried by ego-motion, for too long or too uncertain
  kContradicted,     ///< lost to outliers, as a moment ago: registrations contradict the pose
  kRecovering,       ///< the pose was given up: global localization, nearby first
};

enum class TrackingEvent {
  kPriorGiven,  ///< a prior that registrations can start from
  kPlaceFound,  ///< by global localization
  kVerified,    ///< global localization finds no better place than the expected one
  kDoubted,     ///< a scan does not fit the map at the predicted pose, scan after scan fits less
             ///< than it did, fixes contradict the pose persistently, or the along-track position
             ///< is observed again after a tunnel
  kAgreed,  ///< `min_fitting_scans` scans in a row fit, and a registration was accepted meanwhile
  kConfirmed,    ///< `min_accepted_registrations` accepted registrations in a row, where that is
                 ///< enough
  kHoldExpired,  ///< none accepted for `tracking_timeout`, or longer where registrations are rare
  kLossExpired,  ///< none accepted for `dead_reckoning_timeout`, longer likewise, or less certain
                 ///< than `lost_sigma_m`
  kLostAgain,    ///< the same, to outliers, for the second time within `contradiction_span`
  kGivenUp,      ///< see TrackingFailure
};

using TrackingTransition = Transition<TrackingMode, TrackingEvent>;
inline constexpr std::array<TrackingTransition, 24> kTrackingTransitions = {{
    {TrackingMode::kSearching, TrackingEvent::kPriorGiven, TrackingMode::kConfirmingPrior},
    {TrackingMode::kSearching, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},

    {TrackingMode::kConfirmingPrior, TrackingEvent::kVerified, TrackingMode::kConfirmingPlace},
    {TrackingMode::kConfirmingPrior, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kConfirmingPrior, TrackingEvent::kGivenUp, TrackingMode::kSearching},

    {TrackingMode::kConfirmingPlace, TrackingEvent::kConfirmed, TrackingMode::kConfirmed},
    {TrackingMode::kConfirmingPlace, TrackingEvent::kGivenUp, TrackingMode::kSearching},

    {TrackingMode::kConfirmed, TrackingEvent::kDoubted, TrackingMode::kSuspect},
    {TrackingMode::kConfirmed, TrackingEvent::kHoldExpired, TrackingMode::kDeadReckoning},

    {TrackingMode::kSuspect, TrackingEvent::kAgreed, TrackingMode::kConfirmed},
    {TrackingMode::kSuspect, TrackingEvent::kVerified, TrackingMode::kConfirmed},
    {TrackingMode::kSuspect, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kSuspect, TrackingEvent::kHoldExpired, TrackingMode::kDeadReckoning},

    {TrackingMode::kDeadReckoning, TrackingEvent::kConfirmed, TrackingMode::kConfirmed},
    {TrackingMode::kDeadReckoning, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kDeadReckoning, TrackingEvent::kLossExpired, TrackingMode::kLost},
    {TrackingMode::kDeadReckoning, TrackingEvent::kLostAgain, TrackingMode::kContradicted},

    {TrackingMode::kLost, TrackingEvent::kConfirmed, TrackingMode::kConfirmed},
    {TrackingMode::kLost, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kLost, TrackingEvent::kGivenUp, TrackingMode::kRecovering},

    {TrackingMode::kContradicted, TrackingEvent::kConfirmed, TrackingMode::kConfirmed},
    {TrackingMode::kContradicted, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kContradicted, TrackingEvent::kGivenUp, TrackingMode::kRecovering},

    {TrackingMode::kRecovering, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
}};

/// How the newest scans lie in the map at the predicted pose.
enum class ScanAgreement {
  kDisagree,            ///< the newest one does not fit
  kAgree,               ///< it fits, or none was tested yet
  kAgreeAndRegistered,  ///< and a registration was accepted since the last scan that did not fit
};

enum class ScanAgreementEvent { kDoesNotFit, kFits, kRegistrationAccepted };

/// A registration that is accepted while scans disagree says little: it is no arrow.
inline constexpr std::array<Transition<ScanAgreement, ScanAgreementEvent>, 4>
    kScanAgreementTransitions = {{
        {ScanAgreement::kDisagree, ScanAgreementEvent::kFits, ScanAgreement::kAgree},
        {ScanAgreement::kAgree, ScanAgreementEvent::kDoesNotFit, ScanAgreement::kDisagree},
        {ScanAgreement::kAgree, ScanAgreementEvent::kRegistrationAccepted,
         ScanAgreement::kAgreeAndRegistered},
        {ScanAgreement::kAgreeAndRegistered, ScanAgreementEvent::kDoesNotFit,
         ScanAgreement::kDisagree},
    }};

/// What the mode kConfirmed takes. Verification: global localization searches beside the pose and
/// finds no better place.
enum class ConfirmationRequirement {
  kRegistrations,               ///< accepted registrations, or scans that fit, are enough
  kRecoveredFitOrVerification,  ///< scan after scan fits a little less than it did: fits as before,
                                ///< or verification, must come first
  kAgreeingFixOrVerification,   ///< fixes contradict the pose persistently: one that agrees, or
                                ///< verification, must come first
  /// Global localization must verify the pose first: the vehicle may be elsewhere, where scans
  /// would fit as well.
  kVerification,
};

enum class ConfirmationEvent {
  /// Scans contradict the pose on ground that repeats, or the along-track position was not observed
  /// before: registrations would match wherever odometry had put it.
  kMayBeElsewhere,
  kFitDeclines,
  kFitRecovers,
  kFixesContradict,
  kFixAgrees,
  kVerified
};

inline constexpr std::array<Transition<ConfirmationRequirement, ConfirmationEvent>, 11>
    kConfirmationTransitions = {{
        {ConfirmationRequirement::kRegistrations, ConfirmationEvent::kMayBeElsewhere,
         ConfirmationRequirement::kVerification},
        {ConfirmationRequirement::kRegistrations, ConfirmationEvent::kFixesContradict,
         ConfirmationRequirement::kAgreeingFixOrVerification},
        {ConfirmationRequirement::kRegistrations, ConfirmationEvent::kFitDeclines,
         ConfirmationRequirement::kRecoveredFitOrVerification},
        {ConfirmationRequirement::kRecoveredFitOrVerification, ConfirmationEvent::kMayBeElsewhere,
         ConfirmationRequirement::kVerification},
        {ConfirmationRequirement::kRecoveredFitOrVerification, ConfirmationEvent::kFitRecovers,
         ConfirmationRequirement::kRegistrations},
        {ConfirmationRequirement::kRecoveredFitOrVerification, ConfirmationEvent::kFixesContradict,
         ConfirmationRequirement::kAgreeingFixOrVerification},
        {ConfirmationRequirement::kRecoveredFitOrVerification, ConfirmationEvent::kVerified,
         ConfirmationRequirement::kRegistrations},
        {ConfirmationRequirement::kAgreeingFixOrVerification, ConfirmationEvent::kMayBeElsewhere,
         ConfirmationRequirement::kVerification},
        {ConfirmationRequirement::kAgreeingFixOrVerification, ConfirmationEvent::kFixAgrees,
         ConfirmationRequirement::kRegistrations},
        {ConfirmationRequirement::kAgreeingFixOrVerification, ConfirmationEvent::kVerified,
         ConfirmationRequirement::kRegistrations},
        {ConfirmationRequirement::kVerification, ConfirmationEvent::kVerified,
         ConfirmationRequirement::kRegistrations},
    }};

/// Whether registrations observe both horizontal directions. Single ones may say either by chance.
enum class AlongTrackObservability {
  kObserved,
  kFading,       ///< not observed, but not yet for `max_unobserved`
  kNotObserved,  ///< as in a smooth tunnel: odometry alone says where along it the vehicle is
  kReturning,    ///< observed again, but not yet for `min_observed`
};

enum class ObservabilityEvent { kSeen, kUnseen, kSeenForLong, kUnseenForLong };

inline constexpr std::array<Transition<AlongTrackObservability, ObservabilityEvent>, 6>
    kObservabilityTransitions = {{
        {AlongTrackObservability::kObserved, ObservabilityEvent::kUnseen,
         AlongTrackObservability::kFading},
        {AlongTrackObservability::kFading, ObservabilityEvent::kSeen,
         AlongTrackObservability::kObserved},
        {AlongTrackObservability::kFading, ObservabilityEvent::kUnseenForLong,
         AlongTrackObservability::kNotObserved},
        {AlongTrackObservability::kNotObserved, ObservabilityEvent::kSeen,
         AlongTrackObservability::kReturning},
        {AlongTrackObservability::kReturning, ObservabilityEvent::kUnseen,
         AlongTrackObservability::kNotObserved},
        {AlongTrackObservability::kReturning, ObservabilityEvent::kSeenForLong,
         AlongTrackObservability::kObserved},
    }};

/// A state that follows its table.
inline TrackingMode Next(TrackingMode mode, TrackingEvent event) {
  return Next(kTrackingTransitions, mode, event);
}
inline ScanAgreement Next(ScanAgreement agreement, ScanAgreementEvent event) {
  return Next(kScanAgreementTransitions, agreement, event);
}
inline ConfirmationRequirement Next(ConfirmationRequirement requirement, ConfirmationEvent event) {
  return Next(kConfirmationTransitions, requirement, event);
}
inline AlongTrackObservability Next(AlongTrackObservability observability,
                                    ObservabilityEvent event) {
  return Next(kObservabilityTransitions, observability, event);
}

}  // namespace dcloc
