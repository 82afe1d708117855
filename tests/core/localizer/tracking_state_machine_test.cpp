#include "core/localizer/tracking_state_machine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr TrackingOptions kOptions{
    .min_accepted_registrations = 3, .tracking_timeout = milliseconds(400), .lost_sigma_m = 2.0};

Stamp StampAt(int ms) { return Stamp(milliseconds(1'000'000 + ms)); }

// One scan with a registration and its answer.
void Scan(TrackingStateMachine& state, int ms, bool accepted, double sigma_m = 0.1) {
  state.OnRegistration(StampAt(ms),
                       accepted ? RegistrationOutcome::kAccepted : RegistrationOutcome::kNoMatch);
  state.ExpireTimeouts(StampAt(ms), sigma_m);
}

// One that began from a prior that was held against other places.
TrackingStateMachine Started(const TrackingOptions& options = kOptions) {
  TrackingStateMachine state(options);
  state.OnPrior();
  state.OnVerified();
  return state;
}

// One without a pose, to which a place was found.
TrackingStateMachine Found() {
  TrackingStateMachine state(kOptions);
  state.OnPlaceFound();
  return state;
}

TrackingStateMachine Tracking(int until_ms) {
  TrackingStateMachine state = Started();
  for (int ms = 0; ms <= until_ms; ms += 100) Scan(state, ms, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  return state;
}

TEST(TrackingStateMachineTest, TracksAfterConfirmationsInARow) {
  TrackingStateMachine state = Started();
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  Scan(state, 0, true);
  Scan(state, 100, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  Scan(state, 200, false);
  Scan(state, 300, true);
  Scan(state, 400, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  Scan(state, 500, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, APriorIsNotTrackedBeforeItIsVerified) {
  TrackingStateMachine state(kOptions);
  state.OnPrior();
  EXPECT_TRUE(state.ShouldSearchBeside());
  for (int ms = 0; ms < 2000; ms += 100) Scan(state, ms, true);
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
  Scan(state, 1100, true);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect) << "made of the scans before";
  for (int i = 0; i < kOptions.min_fitting_scans; ++i) state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect) << "without a registration since";
  Scan(state, 1200, true);
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
    Scan(state, ms, true);
  }
  EXPECT_NE(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, SlowRadarsAreHeldForLonger) {
  TrackingStateMachine state = Started();
  for (int ms = 0; ms <= 10'000; ms += 500) Scan(state, ms, true);
  state.ExpireTimeouts(StampAt(11'000), 0.1);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking) << "one was missed";
  state.ExpireTimeouts(StampAt(11'800), 0.1);
  EXPECT_NE(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, InitializingStaysHoweverUncertain) {
  TrackingStateMachine state = Started();
  for (int ms = 0; ms < 5000; ms += 100) Scan(state, ms, false, 50.0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
}

TEST(TrackingStateMachineTest, AShortGapIsHeldALongerOneIsDeadReckoning) {
  TrackingStateMachine state = Tracking(1000);
  Scan(state, 1100, false);
  state.ExpireTimeouts(StampAt(1400), 0.2);  // a scan without a registration
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  state.ExpireTimeouts(StampAt(1401), 0.2);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
}

TEST(TrackingStateMachineTest, DeadReckoningGrownUncertainIsLost) {
  TrackingStateMachine state = Tracking(1000);
  Scan(state, 1500, false, 1.99);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
  EXPECT_FALSE(state.is_lost());
  Scan(state, 1600, false, 2.01);
  EXPECT_TRUE(state.is_lost());
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  Scan(state, 1700, false, 1.0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
}

TEST(TrackingStateMachineTest, LostIsReportedWithinASecondOfTheLastConfirmation) {
  constexpr int kLast_ms = 1000;
  TrackingStateMachine state = Tracking(kLast_ms);
  constexpr int kScan_ms = 77;
  int reported_ms = 0;
  for (int ms = kLast_ms + kScan_ms; ms < 10'000; ms += kScan_ms) {
    Scan(state, ms, false, 0.3);
    if (reported_ms == 0 && state.Report(0.1) == LocalizationState::kLost) reported_ms = ms;
    EXPECT_TRUE(reported_ms == 0 || state.Report(0.1) == LocalizationState::kLost) << ms;
  }
  EXPECT_GT(reported_ms, kLast_ms + 800) << "a short gap is bridged";
  EXPECT_LE(reported_ms, kLast_ms + 1000);
}

TEST(TrackingStateMachineTest, LostIsSearchedForOnlyWhileUncertain) {
  TrackingStateMachine state = Tracking(1000);
  for (int ms = 2000; ms < 60'000; ms += 100) Scan(state, ms, false, 1.5);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(60'000), 1.5), TrackingFailure::kNone);
  Scan(state, 60'000, false, 2.1);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(61'000), 2.1), TrackingFailure::kNone);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(61'001), 2.1), TrackingFailure::kUncertain);
  EXPECT_FALSE(state.has_pose());
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  state.OnPlaceFound();
  for (int ms = 61'100; ms < 61'400; ms += 100) Scan(state, ms, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(70'000), 0.1), TrackingFailure::kNone);
}

TEST(TrackingStateMachineTest, OneConfirmationAloneDoesNotEndBeingLost) {
  TrackingStateMachine state = Tracking(1000);
  for (int ms = 1100; ms <= 2500; ms += 100) Scan(state, ms, false);
  Scan(state, 2600, true);
  Scan(state, 2700, false);
  Scan(state, 2800, true);
  Scan(state, 2900, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  Scan(state, 3000, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, UncertainWhileTheMapConfirmsIsStillTracking) {
  TrackingStateMachine state = Tracking(1000);
  Scan(state, 1100, true, 3.0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, ConfirmationsInARowRecoverFromBoth) {
  for (const double sigma_m : {0.5, 5.0}) {
    TrackingStateMachine state = Tracking(1000);
    Scan(state, 2000, false, sigma_m);
    EXPECT_NE(state.Report(0.1), LocalizationState::kTracking);
    Scan(state, 2100, true);
    Scan(state, 2200, true);
    EXPECT_NE(state.Report(0.1), LocalizationState::kTracking);
    Scan(state, 2300, true);
    EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  }
}

TEST(TrackingStateMachineTest, AfterLostAllConfirmationsAreNeeded) {
  TrackingStateMachine state = Tracking(1000);
  // Silence, without a registration that could have failed.
  state.ExpireTimeouts(StampAt(60'000), 30.0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  Scan(state, 60'000, true);
  Scan(state, 60'100, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  Scan(state, 60'200, true);
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
  for (const int end_ms = ms + 500; ms < end_ms; ms += 100) Scan(state, ms, true);
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
  for (int ms = 3000; ms < 20'000; ms += 100) Scan(state, ms, true);
  Contradict(state, 20'000, false);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(21'100), 0.1), TrackingFailure::kNone);
}

TEST(TrackingStateMachineTest, WhereTheMapIsEmptyNothingContradicts) {
  TrackingStateMachine state = Tracking(1000);
  for (const int begin_ms : {1100, 2700}) {
    for (int ms = begin_ms; ms <= begin_ms + 1000; ms += 100) Scan(state, ms, false);
    EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
    EXPECT_EQ(state.GiveUpIfFailed(StampAt(begin_ms + 1000), 0.1), TrackingFailure::kNone);
    for (int ms = begin_ms + 1100; ms < begin_ms + 1600; ms += 100) Scan(state, ms, true);
  }
}

TEST(TrackingStateMachineTest, AFoundPlaceIsConfirmedAndThenTracks) {
  TrackingStateMachine state = Found();
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  Scan(state, 1100, true);
  Scan(state, 1200, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  Scan(state, 1300, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, AFoundPlaceThatIsRefusedIsGivenUp) {
  TrackingStateMachine state = Found();
  Scan(state, 0, true);
  Scan(state, 100, false);
  Scan(state, 200, false);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(200), 0.1), TrackingFailure::kNone);
  Scan(state, 300, false);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(300), 0.1), TrackingFailure::kPlaceRefused);
  EXPECT_EQ(state.mode(), TrackingMode::kSearching);
}

TEST(TrackingStateMachineTest, AnUnconfirmedPriorThatHasGrownTooWideIsGivenUp) {
  TrackingStateMachine state(kOptions);
  state.OnPrior();
  for (int ms = 0; ms < 2000; ms += 100) Scan(state, ms, false);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(2000), kOptions.max_prior_sigma_m),
            TrackingFailure::kNone);
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(2000), kOptions.max_prior_sigma_m + 0.1),
            TrackingFailure::kPriorTooWide);
  EXPECT_EQ(state.mode(), TrackingMode::kSearching);
}

// Goes on with accepted registrations, which observe the way or not.
void Observe(TrackingStateMachine& state, int& ms, int until_ms, bool is_observed) {
  for (; ms <= until_ms; ms += 100) {
    Scan(state, ms, true);
    state.OnObservability(StampAt(ms), is_observed);
  }
}

TEST(TrackingStateMachineTest, AWayThatNothingObservesIsNoTracking) {
  TrackingStateMachine state = Tracking(1000);
  int ms = 1100;
  Observe(state, ms, 3000, false);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
  Observe(state, ms, 7000, true);
  EXPECT_TRUE(state.ShouldSearchBeside());
  state.OnFixAgrees();
  for (int i = 0; i < 5; ++i) state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);  // that is not enough
  state.OnVerified();
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, SingleRegistrationsThatDoNotObserveTheWayMeanNothing) {
  TrackingStateMachine state = Tracking(1000);
  int ms = 1100;
  for (int i = 0; i < 20; ++i) Observe(state, ms, ms + 100, i % 2 == 0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingStateMachineTest, AWayThatIsObservedForAMomentIsStillUnobserved) {
  TrackingStateMachine state = Tracking(1000);
  int ms = 1100;
  Observe(state, ms, 3000, false);
  Observe(state, ms, 4900, true);   // a hundred milliseconds too short
  Observe(state, ms, 5000, false);  // it does not last
  Observe(state, ms, 6900, true);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed) << "nothing to verify yet";
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
  Observe(state, ms, 7100, true);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect);
}

TEST(TrackingStateMachineTest, AfterATunnelFixesThatAgreeAreNotEnough) {
  TrackingStateMachine state = Tracking(1000);
  state.OnFixesContradict();
  int ms = 1100;
  Observe(state, ms, 3000, false);
  Observe(state, ms, 7000, true);
  state.OnFixesContradict();
  state.OnFixAgrees();
  for (int i = 0; i < 5; ++i) state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect);
  state.OnVerified();
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

TEST(TrackingStateMachineTest, FixesThatContradictAskForVerification) {
  TrackingStateMachine state = Tracking(1000);
  state.OnFixesContradict();
  Scan(state, 1100, true);
  for (int i = 0; i < 5; ++i) state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect);
  state.OnFixAgrees();
  for (int i = 0; i < 5; ++i) state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

TEST(TrackingStateMachineTest, FixesThatContradictWhileAPlaceIsConfirmedAskForVerification) {
  TrackingStateMachine state = Found();
  EXPECT_FALSE(state.ShouldSearchBeside());
  state.OnFixesContradict();
  for (int ms = 0; ms < 1000; ms += 100) Scan(state, ms, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  EXPECT_TRUE(state.ShouldSearchBeside()) << "else nothing would ever end it";
  state.OnVerified();
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  EXPECT_FALSE(state.ShouldSearchBeside());
}

TEST(TrackingStateMachineTest, AnUncertainPoseIsNotCalledTracking) {
  const TrackingStateMachine state = Tracking(1000);
  EXPECT_EQ(state.Report(kOptions.tracking_sigma_m), LocalizationState::kTracking);
  EXPECT_EQ(state.Report(kOptions.tracking_sigma_m + 0.01), LocalizationState::kDeadReckoning);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

}  // namespace
}  // namespace dcloc
