#include "core/localizer/tracking_state_machine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "tests/core/localizer/tracking_drive.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

TEST(TrackingStateMachineTest, TracksAfterConfirmationsInARow) {
  TrackingStateMachine state = Started();
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  ScanAt(state, 0, true);
  ScanAt(state, 100, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  ScanAt(state, 200, false);
  ScanAt(state, 300, true);
  ScanAt(state, 400, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  ScanAt(state, 500, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, APriorIsNotTrackedBeforeItIsVerified) {
  TrackingStateMachine state(kTrackingOptions);
  state.OnPrior();
  EXPECT_TRUE(state.ShouldSearchBeside());
  for (int ms = 0; ms < 2000; ms += 100) ScanAt(state, ms, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  state.OnVerified();
  EXPECT_FALSE(state.ShouldSearchBeside());
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking) << "it was confirmed before";
}

TEST(TrackingStateMachineTest, AScanThatDoesNotFitEndsTrackingAtOnce) {
  TrackingStateMachine state = Tracking(1000);
  state.OnScanFit(ScanFit::kUnknown);
  state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
  state.OnScanFit(ScanFit::kContradicts);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
  EXPECT_TRUE(state.ShouldSearchBeside());
}

TEST(TrackingStateMachineTest, ADoubtEndsWhenScansAndARegistrationAgree) {
  TrackingStateMachine state = Tracking(1000);
  state.OnScanFit(ScanFit::kContradicts);
  ScanAt(state, 1100, true);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect) << "made of the scans before";
  for (int i = 0; i < kTrackingOptions.min_fitting_scans; ++i) state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect) << "without a registration since";
  ScanAt(state, 1200, true);
  state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

TEST(TrackingStateMachineTest, ADoubtEndsWhenThePoseIsVerified) {
  TrackingStateMachine state = Tracking(1000);
  state.OnScanFit(ScanFit::kContradicts);
  state.OnVerified();
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

// Whatever was claimed before, a place just found is confirmed from the beginning.
TEST(TrackingStateMachineTest, APlaceFoundWhileThePoseIsInDoubtIsConfirmedFirst) {
  for (const int silent_ms : {0, 600, 2000}) {  // suspect, dead reckoning, lost
    TrackingStateMachine state = Tracking(1000);
    state.OnScanFit(ScanFit::kContradicts);
    state.ExpireTimeouts(StampAt(1000 + silent_ms), 0.1);
    state.OnPlaceFound();
    EXPECT_EQ(state.mode(), TrackingMode::kConfirmingPlace) << silent_ms;
    EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing) << silent_ms;
  }
}

TEST(TrackingStateMachineTest, RegistrationsConfirmNothingWhileScansContradict) {
  TrackingStateMachine state = Tracking(1000);
  state.ExpireTimeouts(StampAt(1600), 0.1);
  EXPECT_EQ(state.mode(), TrackingMode::kDeadReckoning);
  for (int ms = 1700; ms < 3000; ms += 100) {
    state.OnScanFit(ScanFit::kContradicts);
    ScanAt(state, ms, true);
  }
  EXPECT_NE(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, SlowRadarsAreHeldForLonger) {
  TrackingStateMachine state = Started();
  for (int ms = 0; ms <= 10'000; ms += 500) ScanAt(state, ms, true);
  state.ExpireTimeouts(StampAt(11'000), 0.1);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking) << "one was missed";
  state.ExpireTimeouts(StampAt(11'800), 0.1);
  EXPECT_NE(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, InitializingStaysHoweverUncertain) {
  TrackingStateMachine state = Started();
  for (int ms = 0; ms < 5000; ms += 100) ScanAt(state, ms, false, 50.0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
}

TEST(TrackingStateMachineTest, AShortGapIsHeldALongerOneIsDeadReckoning) {
  TrackingStateMachine state = Tracking(1000);
  ScanAt(state, 1100, false);
  state.ExpireTimeouts(StampAt(1400), 0.2);  // a scan without a registration
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  state.ExpireTimeouts(StampAt(1401), 0.2);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
}

TEST(TrackingStateMachineTest, DeadReckoningGrownUncertainIsLost) {
  TrackingStateMachine state = Tracking(1000);
  ScanAt(state, 1500, false, 1.99);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
  EXPECT_FALSE(state.is_lost());
  ScanAt(state, 1600, false, 2.01);
  EXPECT_TRUE(state.is_lost());
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  ScanAt(state, 1700, false, 1.0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
}

TEST(TrackingStateMachineTest, LostIsReportedWithinASecondOfTheLastConfirmation) {
  constexpr int kLast_ms = 1000;
  TrackingStateMachine state = Tracking(kLast_ms);
  constexpr int kScan_ms = 77;
  int reported_ms = 0;
  for (int ms = kLast_ms + kScan_ms; ms < 10'000; ms += kScan_ms) {
    ScanAt(state, ms, false, 0.3);
    if (reported_ms == 0 && state.Report(0.1) == LocalizationState::kLost) reported_ms = ms;
    EXPECT_TRUE(reported_ms == 0 || state.Report(0.1) == LocalizationState::kLost) << ms;
  }
  EXPECT_GT(reported_ms, kLast_ms + 800) << "a short gap is bridged";
  EXPECT_LE(reported_ms, kLast_ms + 1000);
}

TEST(TrackingStateMachineTest, LostIsSearchedForOnlyWhileUncertain) {
  TrackingStateMachine state = Tracking(1000);
  for (int ms = 2000; ms < 60'000; ms += 100) ScanAt(state, ms, false, 1.5);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(60'000), 1.5), TrackingFailure::kNone);
  ScanAt(state, 60'000, false, 2.1);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(61'000), 2.1), TrackingFailure::kNone);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(61'001), 2.1), TrackingFailure::kUncertain);
  EXPECT_FALSE(state.has_pose());
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  state.OnPlaceFound();
  for (int ms = 61'100; ms < 61'400; ms += 100) ScanAt(state, ms, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(70'000), 0.1), TrackingFailure::kNone);
}

TEST(TrackingStateMachineTest, OneConfirmationAloneDoesNotEndBeingLost) {
  TrackingStateMachine state = Tracking(1000);
  for (int ms = 1100; ms <= 2500; ms += 100) ScanAt(state, ms, false);
  ScanAt(state, 2600, true);
  ScanAt(state, 2700, false);
  ScanAt(state, 2800, true);
  ScanAt(state, 2900, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  ScanAt(state, 3000, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, UncertainWhileTheMapConfirmsIsStillTracking) {
  TrackingStateMachine state = Tracking(1000);
  ScanAt(state, 1100, true, 3.0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, ConfirmationsInARowRecoverFromBoth) {
  for (const double sigma_m : {0.5, 5.0}) {
    TrackingStateMachine state = Tracking(1000);
    ScanAt(state, 2000, false, sigma_m);
    EXPECT_NE(state.Report(0.1), LocalizationState::kTracking);
    ScanAt(state, 2100, true);
    ScanAt(state, 2200, true);
    EXPECT_NE(state.Report(0.1), LocalizationState::kTracking);
    ScanAt(state, 2300, true);
    EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  }
}

TEST(TrackingStateMachineTest, AfterLostAllConfirmationsAreNeeded) {
  TrackingStateMachine state = Tracking(1000);
  // Silence, without a registration that could have failed.
  state.ExpireTimeouts(StampAt(60'000), 30.0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  ScanAt(state, 60'000, true);
  ScanAt(state, 60'100, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  ScanAt(state, 60'200, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

// One second of outliers from `ms` on and then, if it `recovers`, some accepted registrations.
void Contradict(TrackingStateMachine& state, int ms, bool recovers = true) {
  for (const int end_ms = ms + 1000; ms <= end_ms; ms += 100) {
    state.OnRegistration(StampAt(ms), RegistrationOutcome::kOutlier);
    state.ExpireTimeouts(StampAt(ms), 0.1);
  }
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  if (!recovers) return;
  for (const int end_ms = ms + 500; ms < end_ms; ms += 100) ScanAt(state, ms, true);
}

TEST(TrackingStateMachineTest, LostToOutliersTwiceIsContradicted) {
  TrackingStateMachine state = Tracking(1000);
  Contradict(state, 1100);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(2700), 0.1), TrackingFailure::kNone);
  for (int ms = 2700; state.Report(0.1) != LocalizationState::kLost; ms += 100) {
    state.OnRegistration(StampAt(ms), RegistrationOutcome::kOutlier);
    state.ExpireTimeouts(StampAt(ms), 0.1);
  }
  EXPECT_EQ(state.mode(), TrackingMode::kContradicted);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(4000), 0.1), TrackingFailure::kContradicted);
  EXPECT_EQ(state.mode(), TrackingMode::kRecovering);
  state.OnPlaceFound();
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(4100), 0.1), TrackingFailure::kNone);
}

TEST(TrackingStateMachineTest, OutliersFarApartAreTwoBursts) {
  TrackingStateMachine state = Tracking(1000);
  Contradict(state, 1100);
  for (int ms = 3000; ms < 20'000; ms += 100) ScanAt(state, ms, true);
  Contradict(state, 20'000, false);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(21'100), 0.1), TrackingFailure::kNone);
}

TEST(TrackingStateMachineTest, WhereTheMapIsEmptyNothingContradicts) {
  TrackingStateMachine state = Tracking(1000);
  for (const int begin_ms : {1100, 2700}) {
    for (int ms = begin_ms; ms <= begin_ms + 1000; ms += 100) ScanAt(state, ms, false);
    EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
    EXPECT_EQ(state.GiveUpIfFailed(StampAt(begin_ms + 1000), 0.1), TrackingFailure::kNone);
    for (int ms = begin_ms + 1100; ms < begin_ms + 1600; ms += 100) ScanAt(state, ms, true);
  }
}

TEST(TrackingStateMachineTest, AFoundPlaceIsConfirmedAndThenTracks) {
  TrackingStateMachine state = Found();
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  ScanAt(state, 1100, true);
  ScanAt(state, 1200, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  ScanAt(state, 1300, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, AFoundPlaceThatIsRefusedIsGivenUp) {
  TrackingStateMachine state = Found();
  ScanAt(state, 0, true);
  ScanAt(state, 100, false);
  ScanAt(state, 200, false);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(200), 0.1), TrackingFailure::kNone);
  ScanAt(state, 300, false);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(300), 0.1), TrackingFailure::kPlaceRefused);
  EXPECT_EQ(state.mode(), TrackingMode::kSearching);
}

TEST(TrackingStateMachineTest, AnUnconfirmedPriorThatHasGrownTooWideIsGivenUp) {
  TrackingStateMachine state(kTrackingOptions);
  state.OnPrior();
  for (int ms = 0; ms < 2000; ms += 100) ScanAt(state, ms, false);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(2000), kTrackingOptions.max_prior_sigma_m),
            TrackingFailure::kNone);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(2000), kTrackingOptions.max_prior_sigma_m + 0.1),
            TrackingFailure::kPriorTooWide);
  EXPECT_EQ(state.mode(), TrackingMode::kSearching);
}

TEST(TrackingStateMachineTest, AnUncertainPoseIsNotCalledTracking) {
  const TrackingStateMachine state = Tracking(1000);
  EXPECT_EQ(state.Report(kTrackingOptions.tracking_sigma_m), LocalizationState::kTracking);
  EXPECT_EQ(state.Report(kTrackingOptions.tracking_sigma_m + 0.01),
            LocalizationState::kDeadReckoning);
  EXPECT_EQ(state.Report(0.1, kTrackingOptions.tracking_sigma_rad), LocalizationState::kTracking);
  EXPECT_EQ(state.Report(0.1, kTrackingOptions.tracking_sigma_rad + 0.01),
            LocalizationState::kDeadReckoning);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

}  // namespace
}  // namespace dcloc
