#pragma once

#include <array>

#include "core/localizer/transition.h"

/// The states of TrackingStateMachine, as tables of arrows. The mode is what answers report; the
/// other three say which evidence is still missing, in any mode. STATES.md draws them.
namespace dcloc {

enum class TrackingMode {
  kSearching,        ///< no pose: global localization from nothing or from a vague prior
  kConfirmingPrior,  ///< a pose from a prior that no registration has confirmed yet
  kConfirmingPlace,  ///< a pose from global localization that must be confirmed
  kConfirmed,        ///< a pose that registrations have confirmed; TRACKING, if it is certain too
  kDoubting,         ///< a pose that was confirmed, but scans or fixes now contradict it
  kDeadReckoning,    ///< a pose carried by ego-motion, confirmed a moment ago
  kLost,             ///< a pose carried by ego-motion, for too long or too uncertain
  kLostTwice,        ///< lost to outliers, as a moment ago: registrations contradict the pose
  kRecovering,       ///< the pose was given up: global localization, nearby first
};

enum class TrackingEvent {
  kPriorGiven,   ///< a prior that registrations can start from
  kPlaceFound,   ///< by global localization
  kVerified,     ///< global localization finds no better place than the expected one
  kDoubted,      ///< a scan does not fit the map at the predicted pose, or fixes contradict it
  kAgreed,       ///< `agreements` scans in a row fit, and a registration was accepted meanwhile
  kConfirmed,    ///< `confirmations` accepted registrations in a row, where that is enough
  kHoldExpired,  ///< none accepted for `tracking_hold`
  kLossExpired,  ///< none accepted for `lost_after`, or less certain than `lost_sigma_m`
  kLostAgain,    ///< the same, to outliers, for the second time within `contradiction_span`
  kGivenUp,      ///< see Loss
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

    {TrackingMode::kConfirmed, TrackingEvent::kDoubted, TrackingMode::kDoubting},
    {TrackingMode::kConfirmed, TrackingEvent::kHoldExpired, TrackingMode::kDeadReckoning},

    {TrackingMode::kDoubting, TrackingEvent::kAgreed, TrackingMode::kConfirmed},
    {TrackingMode::kDoubting, TrackingEvent::kVerified, TrackingMode::kConfirmed},
    {TrackingMode::kDoubting, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kDoubting, TrackingEvent::kHoldExpired, TrackingMode::kDeadReckoning},

    {TrackingMode::kDeadReckoning, TrackingEvent::kConfirmed, TrackingMode::kConfirmed},
    {TrackingMode::kDeadReckoning, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kDeadReckoning, TrackingEvent::kLossExpired, TrackingMode::kLost},
    {TrackingMode::kDeadReckoning, TrackingEvent::kLostAgain, TrackingMode::kLostTwice},

    {TrackingMode::kLost, TrackingEvent::kConfirmed, TrackingMode::kConfirmed},
    {TrackingMode::kLost, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kLost, TrackingEvent::kGivenUp, TrackingMode::kRecovering},

    {TrackingMode::kLostTwice, TrackingEvent::kConfirmed, TrackingMode::kConfirmed},
    {TrackingMode::kLostTwice, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
    {TrackingMode::kLostTwice, TrackingEvent::kGivenUp, TrackingMode::kRecovering},

    {TrackingMode::kRecovering, TrackingEvent::kPlaceFound, TrackingMode::kConfirmingPlace},
}};

/// How the newest scans lie in the map at the predicted pose.
enum class ScanAgreement {
  kDisagree,            ///< the newest one does not fit
  kAgree,               ///< it fits, or none was tested yet
  kAgreeAndRegistered,  ///< and a registration was accepted since the last one that did not
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

/// Whether accepted registrations and scans that fit are enough for TRACKING, or global
/// localization must hold the pose against other places first.
enum class Verification {
  kNotNeeded,
  kUnlessFixesAgree,  ///< fixes contradict the pose persistently
  kNeeded,            ///< the way was not observed, the pose was lost, or a rival fits better
};

enum class VerificationEvent {
  kFixesContradict,
  kFixAgrees,
  kObservedAgain,  ///< the vehicle comes from where the way was not observed
  kLost,
  kRivalFits,  ///< scans fit another place better than the pose, or fit the pose less than before
  kVerified,
};

inline constexpr std::array<Transition<Verification, VerificationEvent>, 10>
    kVerificationTransitions = {{
        {Verification::kNotNeeded, VerificationEvent::kFixesContradict,
         Verification::kUnlessFixesAgree},
        {Verification::kNotNeeded, VerificationEvent::kObservedAgain, Verification::kNeeded},
        {Verification::kNotNeeded, VerificationEvent::kLost, Verification::kNeeded},
        {Verification::kNotNeeded, VerificationEvent::kRivalFits, Verification::kNeeded},
        {Verification::kUnlessFixesAgree, VerificationEvent::kFixAgrees, Verification::kNotNeeded},
        {Verification::kUnlessFixesAgree, VerificationEvent::kObservedAgain, Verification::kNeeded},
        {Verification::kUnlessFixesAgree, VerificationEvent::kLost, Verification::kNeeded},
        {Verification::kUnlessFixesAgree, VerificationEvent::kRivalFits, Verification::kNeeded},
        {Verification::kUnlessFixesAgree, VerificationEvent::kVerified, Verification::kNotNeeded},
        {Verification::kNeeded, VerificationEvent::kVerified, Verification::kNotNeeded},
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
inline Verification Next(Verification verification, VerificationEvent event) {
  return Next(kVerificationTransitions, verification, event);
}
inline AlongTrackObservability Next(AlongTrackObservability way, ObservabilityEvent event) {
  return Next(kObservabilityTransitions, way, event);
}

}  // namespace dcloc
