#pragma once

#include <gtest/gtest.h>

#include <chrono>

#include "core/localizer/tracking_state_machine.h"

namespace dcloc {

inline constexpr TrackingOptions kTrackingOptions{
    .min_accepted_registrations = 3,
    .tracking_timeout = std::chrono::milliseconds(400),
    .lost_sigma_m = 2.0};

inline Stamp StampAt(int ms) { return Stamp(std::chrono::milliseconds(1'000'000 + ms)); }

/// One scan, which speaks for the place, with a registration and its answer.
inline void ScanAt(TrackingStateMachine& state, int ms, bool accepted, double sigma_m = 0.1) {
  state.OnPlaceEvidence(EvidenceForPlace::kEnough);
  state.OnRegistration(StampAt(ms),
                       accepted ? RegistrationOutcome::kAccepted : RegistrationOutcome::kNoMatch);
  state.ExpireTimeouts(StampAt(ms), sigma_m);
}

/// One that began from a prior that was held against other places.
inline TrackingStateMachine Started(const TrackingOptions& options = kTrackingOptions) {
  TrackingStateMachine state(options);
  state.OnPrior();
  state.OnVerified();
  return state;
}

/// One without a pose, to which a place was found.
inline TrackingStateMachine Found() {
  TrackingStateMachine state(kTrackingOptions);
  state.OnPlaceFound();
  return state;
}

inline TrackingStateMachine Tracking(int until_ms) {
  TrackingStateMachine state = Started();
  for (int ms = 0; ms <= until_ms; ms += 100) ScanAt(state, ms, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  return state;
}

}  // namespace dcloc
