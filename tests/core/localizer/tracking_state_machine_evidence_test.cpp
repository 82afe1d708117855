#include "tests/core/localizer/tracking_drive.h"

namespace dcloc {
namespace {

// Ground that repeats fits again elsewhere.
TEST(TrackingEvidenceTest, ScanAfterScanThatDoesNotFitAsksForVerification) {
  TrackingStateMachine state = Tracking(1000);
  for (int i = 0; i < kTrackingOptions.min_contradicting_scans; ++i) {
    EXPECT_FALSE(state.requires_verification());
    state.OnScanFit(ScanFit::kContradicts, true);
  }
  EXPECT_TRUE(state.requires_verification());
  for (int ms = 1100; ms <= 2000; ms += 100) {
    state.OnScanFit(ScanFit::kAgrees);
    ScanAt(state, ms, true);
    EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
  }
  state.OnVerified();
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingEvidenceTest, WhereNothingElseLooksAlikeScansThatFitAgainAreEnough) {
  TrackingStateMachine state = Tracking(1000);
  for (int i = 0; i < 10; ++i) state.OnScanFit(ScanFit::kContradicts, false);
  EXPECT_FALSE(state.requires_verification());
}

TEST(TrackingEvidenceTest, SingleScansThatDoNotFitAskForNoVerification) {
  TrackingStateMachine state = Tracking(1000);
  for (int i = 0; i < 10; ++i) {
    state.OnScanFit(ScanFit::kContradicts, true);
    state.OnScanFit(ScanFit::kAgrees, true);
  }
  EXPECT_FALSE(state.requires_verification());
}

// Goes on with accepted registrations, which observe the way or not.
void Observe(TrackingStateMachine& state, int& ms, int until_ms, bool is_observed) {
  for (; ms <= until_ms; ms += 100) {
    ScanAt(state, ms, true);
    state.OnObservability(StampAt(ms), is_observed);
  }
}

TEST(TrackingEvidenceTest, NothingIsTrackingBeforeSomethingSpeaksForThePlace) {
  TrackingStateMachine state = Started();
  for (int ms = 0; ms < 500; ms += 100) {
    state.OnRegistration(StampAt(ms), RegistrationOutcome::kAccepted);
  }
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning);
  state.OnPlaceEvidence(EvidenceForPlace::kEnough);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingEvidenceTest, RegistrationsAtAPlaceForWhichNothingSpeaksConfirmNothing) {
  TrackingStateMachine state = Tracking(1000);
  const auto register_without_evidence = [&](int ms) {
    state.OnPlaceEvidence(EvidenceForPlace::kLacking);
    state.OnRegistration(StampAt(ms), RegistrationOutcome::kAccepted);
    state.ExpireTimeouts(StampAt(ms), 0.1);
  };
  register_without_evidence(1100);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kDeadReckoning) << "at once";
  for (int ms = 1200; ms <= 2500; ms += 100) register_without_evidence(ms);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kLost);
  EXPECT_TRUE(state.ShouldSearchBeside());
  for (int ms = 2600; ms <= 2800; ms += 100) ScanAt(state, ms, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking) << "it speaks for the place again";
}

TEST(TrackingEvidenceTest, APlaceForWhichNothingSpeaksIsNotHandedOn) {
  TrackingStateMachine state = Tracking(1000);
  EXPECT_TRUE(state.Snapshot().has_value());
  for (const auto evidence : {EvidenceForPlace::kLacking, EvidenceForPlace::kTooLittle}) {
    state.OnPlaceEvidence(evidence);
    EXPECT_FALSE(state.Snapshot().has_value());
  }
}

TEST(TrackingEvidenceTest, APlaceThatWasFoundAndForWhichNothingSpeaksIsGivenUp) {
  TrackingStateMachine state = Found();
  state.OnPlaceEvidence(EvidenceForPlace::kLacking);
  for (int ms = 0; ms < 300; ms += 100) {
    EXPECT_EQ(state.GiveUpIfFailed(StampAt(ms), 0.1), TrackingFailure::kNone);
    state.OnRegistration(StampAt(ms), RegistrationOutcome::kAccepted);
  }
  EXPECT_EQ(state.GiveUpIfFailed(StampAt(300), 0.1), TrackingFailure::kPlaceRefused);
}

TEST(TrackingEvidenceTest, AWayThatNothingObservesIsNoTracking) {
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

TEST(TrackingEvidenceTest, SingleRegistrationsThatDoNotObserveTheWayMeanNothing) {
  TrackingStateMachine state = Tracking(1000);
  int ms = 1100;
  for (int i = 0; i < 20; ++i) Observe(state, ms, ms + 100, i % 2 == 0);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
}

TEST(TrackingEvidenceTest, AWayThatIsObservedForAMomentIsStillUnobserved) {
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

TEST(TrackingEvidenceTest, AfterATunnelFixesThatAgreeAreNotEnough) {
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

TEST(TrackingEvidenceTest, FixesThatContradictAskForVerification) {
  TrackingStateMachine state = Tracking(1000);
  state.OnFixesContradict();
  ScanAt(state, 1100, true);
  for (int i = 0; i < 5; ++i) state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect);
  state.OnFixAgrees();
  for (int i = 0; i < 5; ++i) state.OnScanFit(ScanFit::kAgrees);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

TEST(TrackingEvidenceTest, FixesThatContradictWhileAPlaceIsConfirmedAskForVerification) {
  TrackingStateMachine state = Found();
  EXPECT_FALSE(state.ShouldSearchBeside());
  state.OnFixesContradict();
  for (int ms = 0; ms < 1000; ms += 100) ScanAt(state, ms, true);
  EXPECT_EQ(state.Report(0.1), LocalizationState::kInitializing);
  EXPECT_TRUE(state.ShouldSearchBeside()) << "else nothing would ever end it";
  state.OnVerified();
  EXPECT_EQ(state.Report(0.1), LocalizationState::kTracking);
  EXPECT_FALSE(state.ShouldSearchBeside());
}

}  // namespace
}  // namespace dcloc
