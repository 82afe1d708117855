#include "core/localizer/tracking_state.h"

namespace dcloc {

void TrackingState::OnRegistration(Stamp stamp, RegistrationOutcome outcome) {
  const bool believed = outcome == RegistrationOutcome::kAccepted;
  // What was believed before a silence confirms nothing after it.
  if (last_accepted_ && stamp - *last_accepted_ > options_.tracking_hold) {
    accepted_in_a_row_ = 0;
    if (state_ == LocalizationState::kTracking) state_ = LocalizationState::kDeadReckoning;
  }
  accepted_in_a_row_ = believed ? accepted_in_a_row_ + 1 : 0;
  refused_in_a_row_ = believed ? 0 : refused_in_a_row_ + 1;
  contradictions_in_a_row_ =
      outcome == RegistrationOutcome::kOutlier ? contradictions_in_a_row_ + 1 : 0;
  if (believed) last_accepted_ = stamp;
  if (accepted_in_a_row_ < options_.confirmations) return;
  state_ = LocalizationState::kTracking;
  from_global_search_ = false;
  uncertain_since_.reset();
}

void TrackingState::StartFromGlobalSearch() {
  state_ = LocalizationState::kInitializing;
  from_global_search_ = true;
  accepted_in_a_row_ = 0;
  refused_in_a_row_ = 0;
  contradictions_in_a_row_ = 0;
  last_lost_to_contradictions_.reset();
  contradicted_ = false;
  last_accepted_.reset();
  uncertain_since_.reset();
}

bool TrackingState::GlobalStartFailed() const {
  return from_global_search_ && refused_in_a_row_ >= options_.global_start_max_refusals;
}

bool TrackingState::IsLostForGood(Stamp stamp) const {
  return uncertain_since_ && stamp - *uncertain_since_ > options_.lost_hold;
}

void TrackingState::OnAnswer(Stamp stamp, double position_sigma_m) {
  if (state_ == LocalizationState::kInitializing) return;
  const std::chrono::nanoseconds unconfirmed = stamp - *last_accepted_;
  if (state_ == LocalizationState::kTracking && unconfirmed > options_.tracking_hold) {
    state_ = LocalizationState::kDeadReckoning;
  }
  if (state_ == LocalizationState::kTracking) return;
  if (unconfirmed > options_.lost_after) Lose(stamp);
  if (!uncertain_since_ && position_sigma_m > options_.lost_sigma_m) {
    Lose(stamp);
    uncertain_since_ = stamp;
  }
}

// Who is lost must be confirmed anew.
void TrackingState::Lose(Stamp stamp) {
  if (state_ != LocalizationState::kLost && contradictions_in_a_row_ >= options_.confirmations) {
    contradicted_ = last_lost_to_contradictions_ &&
                    stamp - *last_lost_to_contradictions_ <= options_.contradiction_span;
    last_lost_to_contradictions_ = stamp;
  }
  state_ = LocalizationState::kLost;
  accepted_in_a_row_ = 0;
}

}  // namespace dcloc
