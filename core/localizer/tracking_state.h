#pragma once

#include <optional>

#include "core/localizer/localizer.h"
#include "core/localizer/localizer_options.h"

namespace dcloc {

/// What came of a registration: nothing in the map fits, what fits contradicts the estimate, or it
/// agrees.
enum class RegistrationOutcome { kNone, kOutlier, kAccepted };

/// Says what an answer is worth: counts believed registrations and the time since the last one.
class TrackingState {
 public:
  explicit TrackingState(const StateOptions& options) : options_(options) {}

  /// Takes in one registration's outcome at `stamp`.
  void OnRegistration(Stamp stamp, RegistrationOutcome outcome);

  /// Starts over from a place that was found without a prior.
  void StartFromGlobalSearch();

  /// The place found without a prior is contradicted by what followed.
  bool GlobalStartFailed() const;

  /// It began from a prior, and nothing has confirmed it yet.
  bool IsUnconfirmedPrior() const {
    return state_ == LocalizationState::kInitializing && !from_global_search_;
  }

  /// Lost, and for `lost_hold` on ground that is uncertain: to be searched for.
  bool IsLostForGood(Stamp stamp) const;

  /// Lost a second time within `contradiction_span` to registrations that contradict the estimate.
  /// A burst of wrong ones passes, and a step of the true ones is followed; an estimate that took a
  /// wrong place for its own is told again and again.
  bool IsContradicted() const { return contradicted_; }

  /// Takes in the time and the position's standard deviation of an answer, or of the prediction
  /// before a registration: who is lost must be confirmed anew.
  void OnAnswer(Stamp stamp, double position_sigma_m);

  LocalizationState state() const { return state_; }

 private:
  void Lose(Stamp stamp);

  StateOptions options_;
  LocalizationState state_ = LocalizationState::kInitializing;
  bool from_global_search_ = false;
  int accepted_in_a_row_ = 0;
  int refused_in_a_row_ = 0;
  int contradictions_in_a_row_ = 0;
  std::optional<Stamp> last_lost_to_contradictions_;
  bool contradicted_ = false;
  std::optional<Stamp> last_accepted_;
  std::optional<Stamp> uncertain_since_;  // lost, on ground too wide for a prediction
};

}  // namespace dcloc
