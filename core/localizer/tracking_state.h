#pragma once

#include <optional>

#include "core/localizer/localizer.h"
#include "core/localizer/localizer_options.h"

namespace dcloc {

/// Says what an answer is worth: counts believed registrations and the time since the last one.
class TrackingState {
 public:
  explicit TrackingState(const StateOptions& options) : options_(options) {}

  /// Takes in one registration's outcome at `stamp`.
  void OnRegistration(Stamp stamp, bool believed);

  /// Starts over: nothing is confirmed.
  void Reset();

  /// Takes in the time and the position's standard deviation of an answer.
  void OnAnswer(Stamp stamp, double position_sigma_m);

  LocalizationState state() const { return state_; }

 private:
  StateOptions options_;
  LocalizationState state_ = LocalizationState::kInitializing;
  int believed_in_a_row_ = 0;
  std::optional<Stamp> last_believed_;
};

}  // namespace dcloc
