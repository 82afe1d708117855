#include "core/localizer/tracking_state_machine.h"

#include <algorithm>

namespace dcloc {

std::span<const OptionField<TrackingOptions>> FieldsOf(const TrackingOptions& /*options*/) {
  using O = TrackingOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_accepted_registrations", &O::min_accepted_registrations, 1, 1000},
      {"global_start_max_refusals", &O::global_start_max_refusals, 1, 1000},
      {"tracking_timeout_ms", &O::tracking_timeout, 0, 1e6,
       "the first refused registration ends it"},
      {"hold_intervals", &O::hold_intervals, 0, 100, "tracking_timeout_ms alone decides"},
      {"max_usual_interval_ms", &O::max_usual_interval, 0, 1e5,
       "tracking_timeout_ms alone decides"},
      {"interval_forgetting_factor", &O::interval_forgetting_factor, 0, 0.999,
       "the newest interval counts alone"},
      {"min_contradicting_scans", &O::min_contradicting_scans, 1, 1000,
       "a single scan demands a verification"},
      {"min_fitting_scans", &O::min_fitting_scans, 1, 1000},
      {"tracking_sigma_m", &O::tracking_sigma_m, 0, 1000, "nothing is called tracking"},
      {"tracking_sigma_rad", &O::tracking_sigma_rad, 0, 100, "likewise"},
      {"max_unobserved_ms", &O::max_unobserved, 0, 1e6,
       "each registration must observe the along-track position"},
      {"min_observed_ms", &O::min_observed, 0, 1e6, "a single registration will do"},
      {"dead_reckoning_timeout_ms", &O::dead_reckoning_timeout, 0, 1e6,
       "dead reckoning is lost at once"},
      {"lost_sigma_m", &O::lost_sigma_m, 1e-6, 1000},
      {"lost_uncertain_timeout_ms", &O::lost_uncertain_timeout, 1, 1e6},
      {"contradiction_span_ms", &O::contradiction_span, 0, 1e6, "contradictions are never counted"},
      {"max_prior_sigma_m", &O::max_prior_sigma_m, 1e-6, 1000},
  };
  return kFields;
}

absl::Status Validate(const TrackingOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  if (status.ok() && options.dead_reckoning_timeout < options.tracking_timeout) {
    status = absl::InvalidArgumentError(absl::StrFormat(
        "dead_reckoning_timeout_ms is %g; it must not lie below tracking_timeout_ms, %g",
        std::chrono::duration<double, std::milli>(options.dead_reckoning_timeout).count(),
        std::chrono::duration<double, std::milli>(options.tracking_timeout).count()));
  }
  return status;
}

void TrackingStateMachine::OnPlaceFound() {
  const TrackingMode mode = Next(mode_, TrackingEvent::kPlaceFound);
  *this = TrackingStateMachine(options_);
  mode_ = mode;
}

// Registrations that were accepted before the verification count.
void TrackingStateMachine::OnVerified() {
  mode_ = Next(mode_, TrackingEvent::kVerified);
  agreement_ = Next(agreement_, ScanAgreementEvent::kFits);
  confirmation_requires_ = Next(confirmation_requires_, ConfirmationEvent::kVerified);
  Confirm();
}

void TrackingStateMachine::OnFixesContradict() {
  confirmation_requires_ = Next(confirmation_requires_, ConfirmationEvent::kFixesContradict);
  mode_ = Next(mode_, TrackingEvent::kDoubted);
}

void TrackingStateMachine::OnFitTrend(FitTrend trend, bool ground_repeats) {
  fit_trend_ = trend;
  if (trend != FitTrend::kDeclined) {
    confirmation_requires_ = Next(confirmation_requires_, ConfirmationEvent::kFitRecovers);
    return;
  }
  confirmation_requires_ =
      Next(confirmation_requires_,
           ground_repeats ? ConfirmationEvent::kMayBeElsewhere : ConfirmationEvent::kFitDeclines);
  mode_ = Next(mode_, TrackingEvent::kDoubted);
}

void TrackingStateMachine::OnScanFit(ScanFit fit, bool ground_repeats) {
  if (fit == ScanFit::kUnknown) return;
  if (fit == ScanFit::kContradicts) {
    agreement_ = Next(agreement_, ScanAgreementEvent::kDoesNotFit);
    agreed_in_a_row_ = 0;
    ++contradicted_in_a_row_;
    if (ground_repeats && contradicted_in_a_row_ >= options_.min_contradicting_scans) {
      confirmation_requires_ = Next(confirmation_requires_, ConfirmationEvent::kMayBeElsewhere);
    }
    mode_ = Next(mode_, TrackingEvent::kDoubted);
    return;
  }
  contradicted_in_a_row_ = 0;
  agreement_ = Next(agreement_, ScanAgreementEvent::kFits);
  ++agreed_in_a_row_;
  if (agreed_in_a_row_ >= options_.min_fitting_scans &&
      agreement_ == ScanAgreement::kAgreeAndRegistered && fit_trend_ == FitTrend::kUsual &&
      confirmation_requires_ == ConfirmationRequirement::kRegistrations) {
    mode_ = Next(mode_, TrackingEvent::kAgreed);
  }
}

// Registrations of slow radars are rare without anything being wrong.
std::chrono::nanoseconds TrackingStateMachine::Hold() const {
  const auto by_interval = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(options_.hold_intervals * usual_interval_s_));
  return std::max(options_.tracking_timeout, by_interval);
}

void TrackingStateMachine::LearnInterval(Stamp stamp) {
  if (last_registration_) {
    const double interval_s = std::chrono::duration<double>(std::min(stamp - *last_registration_,
                                                                     options_.max_usual_interval))
                                  .count();
    usual_interval_s_ = usual_interval_s_ > 0.0
                            ? options_.interval_forgetting_factor * usual_interval_s_ +
                                  (1.0 - options_.interval_forgetting_factor) * interval_s
                            : interval_s;
  }
  last_registration_ = stamp;
}

void TrackingStateMachine::ExpireTimeouts(Stamp stamp, double position_sigma_m) {
  if (!last_accepted_) return;
  const std::chrono::nanoseconds unconfirmed = stamp - *last_accepted_;
  const std::chrono::nanoseconds hold = Hold();
  if (unconfirmed > hold) mode_ = Next(mode_, TrackingEvent::kHoldExpired);
  const bool is_carried = mode_ == TrackingMode::kDeadReckoning || mode_ == TrackingMode::kLost ||
                          mode_ == TrackingMode::kContradicted;
  if (!is_carried) return;
  if (unconfirmed > options_.dead_reckoning_timeout + (hold - options_.tracking_timeout)) {
    Lose(stamp);
  }
  if (!uncertain_since_ && position_sigma_m > options_.lost_sigma_m) {
    Lose(stamp);
    uncertain_since_ = stamp;
  }
}

// A vehicle that is lost must be confirmed from the beginning.
void TrackingStateMachine::Lose(Stamp stamp) {
  TrackingEvent event = TrackingEvent::kLossExpired;
  if (mode_ == TrackingMode::kDeadReckoning &&
      outliers_in_a_row_ >= options_.min_accepted_registrations) {
    const bool is_again =
        last_lost_to_outliers_ && stamp - *last_lost_to_outliers_ <= options_.contradiction_span;
    if (is_again) event = TrackingEvent::kLostAgain;
    last_lost_to_outliers_ = stamp;
  }
  mode_ = Next(mode_, event);
  accepted_in_a_row_ = 0;
}

void TrackingStateMachine::OnObservability(Stamp stamp, bool is_observed) {
  const AlongTrackObservability before = observability_;
  observability_ =
      Next(observability_, is_observed ? ObservabilityEvent::kSeen : ObservabilityEvent::kUnseen);
  if (observability_ != before) observability_changed_ = stamp;
  const std::chrono::nanoseconds unchanged = stamp - observability_changed_;
  if (!is_observed && unchanged >= options_.max_unobserved) {
    observability_ = Next(observability_, ObservabilityEvent::kUnseenForLong);
  }
  if (observability_ == AlongTrackObservability::kReturning && unchanged >= options_.min_observed) {
    observability_ = Next(observability_, ObservabilityEvent::kSeenForLong);
    confirmation_requires_ = Next(confirmation_requires_, ConfirmationEvent::kMayBeElsewhere);
    mode_ = Next(mode_, TrackingEvent::kDoubted);
  }
}

void TrackingStateMachine::OnRegistration(Stamp stamp, RegistrationOutcome outcome) {
  const bool accepted =
      outcome == RegistrationOutcome::kAccepted && evidence_ != EvidenceForPlace::kLacking;
  // What was accepted before a silence confirms nothing after it.
  if (last_accepted_ && stamp - *last_accepted_ > Hold()) {
    accepted_in_a_row_ = 0;
    mode_ = Next(mode_, TrackingEvent::kHoldExpired);
  }
  LearnInterval(stamp);
  // A registration that agrees with the estimate says little while the scans fit neither.
  const bool confirms = accepted && agreement_ != ScanAgreement::kDisagree;
  accepted_in_a_row_ = confirms ? accepted_in_a_row_ + 1 : 0;
  refused_in_a_row_ = accepted ? 0 : refused_in_a_row_ + 1;
  outliers_in_a_row_ = outcome == RegistrationOutcome::kOutlier ? outliers_in_a_row_ + 1 : 0;
  if (accepted) {
    last_accepted_ = stamp;
    agreement_ = Next(agreement_, ScanAgreementEvent::kRegistrationAccepted);
  }
  Confirm();
}

void TrackingStateMachine::Confirm() {
  const bool is_enough = accepted_in_a_row_ >= options_.min_accepted_registrations &&
                         confirmation_requires_ == ConfirmationRequirement::kRegistrations;
  if (!is_enough) return;
  mode_ = Next(mode_, TrackingEvent::kConfirmed);
  if (mode_ == TrackingMode::kConfirmed) uncertain_since_.reset();
}

TrackingFailure TrackingStateMachine::GiveUpIfFailed(Stamp stamp, double position_sigma_m) {
  const TrackingFailure failure = FindFailure(stamp, position_sigma_m);
  if (failure != TrackingFailure::kNone) mode_ = Next(mode_, TrackingEvent::kGivenUp);
  return failure;
}

TrackingFailure TrackingStateMachine::FindFailure(Stamp stamp, double position_sigma_m) const {
  switch (mode_) {
    case TrackingMode::kConfirmingPlace:
      return refused_in_a_row_ >= options_.global_start_max_refusals
                 ? TrackingFailure::kPlaceRefused
                 : TrackingFailure::kNone;
    case TrackingMode::kConfirmingPrior:
      return position_sigma_m > options_.max_prior_sigma_m ? TrackingFailure::kPriorTooWide
                                                           : TrackingFailure::kNone;
    case TrackingMode::kContradicted:
      return TrackingFailure::kContradicted;
    case TrackingMode::kLost:
      return uncertain_since_ && stamp - *uncertain_since_ > options_.lost_uncertain_timeout
                 ? TrackingFailure::kUncertain
                 : TrackingFailure::kNone;
    case TrackingMode::kSearching:
    case TrackingMode::kConfirmed:
    case TrackingMode::kSuspect:
    case TrackingMode::kDeadReckoning:
    case TrackingMode::kRecovering:
      return TrackingFailure::kNone;
  }
  return TrackingFailure::kNone;
}

LocalizationState TrackingStateMachine::Report(double claimed_position_sigma_m,
                                               double claimed_heading_sigma_rad) const {
  switch (mode_) {
    case TrackingMode::kConfirmed: {
      // However well registrations agree across, a vehicle that does not know where along a tunnel
      // it is does not track.
      const bool is_unobserved = observability_ == AlongTrackObservability::kNotObserved ||
                                 observability_ == AlongTrackObservability::kReturning;
      const bool is_vague = claimed_position_sigma_m > options_.tracking_sigma_m ||
                            claimed_heading_sigma_rad > options_.tracking_sigma_rad;
      return is_unobserved || is_vague || evidence_ != EvidenceForPlace::kEnough
                 ? LocalizationState::kDeadReckoning
                 : LocalizationState::kTracking;
    }
    case TrackingMode::kSuspect:
    case TrackingMode::kDeadReckoning:
      return LocalizationState::kDeadReckoning;
    case TrackingMode::kLost:
    case TrackingMode::kContradicted:
    case TrackingMode::kRecovering:
      return LocalizationState::kLost;
    case TrackingMode::kSearching:
    case TrackingMode::kConfirmingPrior:
    case TrackingMode::kConfirmingPlace:
      return LocalizationState::kInitializing;
  }
  return LocalizationState::kInitializing;
}

}  // namespace dcloc
