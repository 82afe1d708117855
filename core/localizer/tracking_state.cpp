#include "core/localizer/tracking_state.h"

namespace dcloc {

void TrackingState::OnRegistration(Stamp stamp, bool believed) {
  believed_in_a_row_ = believed ? believed_in_a_row_ + 1 : 0;
  if (believed) last_believed_ = stamp;
  if (believed_in_a_row_ >= options_.confirmations) state_ = LocalizationState::kTracking;
}

void TrackingState::Reset() {
  state_ = LocalizationState::kInitializing;
  believed_in_a_row_ = 0;
  last_believed_.reset();
}

void TrackingState::OnAnswer(Stamp stamp, double position_sigma_m) {
  if (state_ == LocalizationState::kInitializing) return;
  if (state_ == LocalizationState::kTracking && stamp - *last_believed_ > options_.tracking_hold) {
    state_ = LocalizationState::kDeadReckoning;
  }
  if (state_ == LocalizationState::kDeadReckoning && position_sigma_m > options_.lost_sigma_m) {
    state_ = LocalizationState::kLost;
  }
}

}  // namespace dcloc
