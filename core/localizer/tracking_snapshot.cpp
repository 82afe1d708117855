// What of a vehicle that has been tracked another state machine goes on from.
#include "absl/strings/str_format.h"
#include "core/localizer/tracking_state_machine.h"

namespace dcloc {
namespace {

// In all others there is no pose, or one that nothing has confirmed, or one that is wrong.
bool HasBeenTracked(TrackingMode mode) {
  return mode == TrackingMode::kConfirmed || mode == TrackingMode::kSuspect ||
         mode == TrackingMode::kDeadReckoning || mode == TrackingMode::kLost;
}

}  // namespace

absl::Status Validate(const TrackingSnapshot& snapshot) {
  constexpr double kMaxInterval_s = 1e3;
  const auto is_of = [](auto value, auto last) {
    return value >= decltype(value){} && value <= last;
  };
  if (!HasBeenTracked(snapshot.mode)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("tracking.mode is %d; it must be one of a vehicle that has been tracked",
                        static_cast<int>(snapshot.mode)));
  }
  if (!is_of(snapshot.confirmation_requires, ConfirmationRequirement::kVerification) ||
      !is_of(snapshot.observability, AlongTrackObservability::kReturning)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("tracking.confirmation_requires and tracking.observability are %d and %d; "
                        "they must be known",
                        static_cast<int>(snapshot.confirmation_requires),
                        static_cast<int>(snapshot.observability)));
  }
  if (!(snapshot.usual_interval_s >= 0.0 && snapshot.usual_interval_s <= kMaxInterval_s)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("tracking.usual_interval_s is %g; it must lie in [0, %g]",
                        snapshot.usual_interval_s, kMaxInterval_s));
  }
  return absl::OkStatus();
}

std::optional<TrackingSnapshot> TrackingStateMachine::Snapshot() const {
  if (!HasBeenTracked(mode_) || !last_accepted_) return std::nullopt;
  if (evidence_ != EvidenceForPlace::kEnough) return std::nullopt;  // `Restore` supposes it
  return TrackingSnapshot{.mode = mode_,
                          .confirmation_requires = confirmation_requires_,
                          .observability = observability_,
                          .observability_changed = observability_changed_,
                          .last_accepted = *last_accepted_,
                          .usual_interval_s = usual_interval_s_,
                          .last_lost_to_outliers = last_lost_to_outliers_};
}

void TrackingStateMachine::Restore(const TrackingSnapshot& snapshot) {
  mode_ = snapshot.mode;
  confirmation_requires_ = snapshot.confirmation_requires;
  evidence_ = EvidenceForPlace::kEnough;  // it was tracked a moment ago
  observability_ = snapshot.observability;
  observability_changed_ = snapshot.observability_changed;
  usual_interval_s_ = snapshot.usual_interval_s;
  last_accepted_ = snapshot.last_accepted;
  last_lost_to_outliers_ = snapshot.last_lost_to_outliers;
}

}  // namespace dcloc
