#include "core/localizer/tracking_state.h"

#include <gtest/gtest.h>

#include <chrono>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr StateOptions kOptions{
    .confirmations = 3, .tracking_hold = milliseconds(400), .lost_sigma_m = 2.0};

Stamp StampAt(int ms) { return Stamp(milliseconds(1'000'000 + ms)); }

// One scan with a registration and its answer.
void Scan(TrackingState& state, int ms, bool believed, double sigma_m = 0.1) {
  state.OnRegistration(StampAt(ms),
                       believed ? RegistrationOutcome::kAccepted : RegistrationOutcome::kNone);
  state.OnAnswer(StampAt(ms), sigma_m);
}

TrackingState Tracking(int until_ms) {
  TrackingState state(kOptions);
  for (int ms = 0; ms <= until_ms; ms += 100) Scan(state, ms, true);
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
  return state;
}

TEST(TrackingStateTest, TracksAfterConfirmationsInARow) {
  TrackingState state(kOptions);
  EXPECT_EQ(state.state(), LocalizationState::kInitializing);
  Scan(state, 0, true);
  Scan(state, 100, true);
  EXPECT_EQ(state.state(), LocalizationState::kInitializing);
  Scan(state, 200, false);
  Scan(state, 300, true);
  Scan(state, 400, true);
  EXPECT_EQ(state.state(), LocalizationState::kInitializing);
  Scan(state, 500, true);
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
}

TEST(TrackingStateTest, InitializingStaysHoweverUncertain) {
  TrackingState state(kOptions);
  for (int ms = 0; ms < 5000; ms += 100) Scan(state, ms, false, 50.0);
  EXPECT_EQ(state.state(), LocalizationState::kInitializing);
}

TEST(TrackingStateTest, AShortGapIsHeldALongerOneIsDeadReckoning) {
  TrackingState state = Tracking(1000);
  Scan(state, 1100, false);
  state.OnAnswer(StampAt(1400), 0.2);  // a scan without a registration
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
  state.OnAnswer(StampAt(1401), 0.2);
  EXPECT_EQ(state.state(), LocalizationState::kDeadReckoning);
}

TEST(TrackingStateTest, DeadReckoningGrownUncertainIsLost) {
  TrackingState state = Tracking(1000);
  Scan(state, 1500, false, 1.99);
  EXPECT_EQ(state.state(), LocalizationState::kDeadReckoning);
  Scan(state, 1600, false, 2.01);
  EXPECT_EQ(state.state(), LocalizationState::kLost);
  Scan(state, 1700, false, 1.0);
  EXPECT_EQ(state.state(), LocalizationState::kLost);
}

TEST(TrackingStateTest, LostIsToldWithinASecondOfTheLastConfirmation) {
  constexpr int kLast_ms = 1000;
  TrackingState state = Tracking(kLast_ms);
  constexpr int kScan_ms = 77;
  int told_ms = 0;
  for (int ms = kLast_ms + kScan_ms; ms < 10'000; ms += kScan_ms) {
    Scan(state, ms, false, 0.3);
    if (told_ms == 0 && state.state() == LocalizationState::kLost) told_ms = ms;
    EXPECT_TRUE(told_ms == 0 || state.state() == LocalizationState::kLost) << ms;
  }
  EXPECT_GT(told_ms, kLast_ms + 800) << "a short gap is bridged";
  EXPECT_LE(told_ms, kLast_ms + 1000);
}

TEST(TrackingStateTest, WhoIsLostOnKnownGroundIsNotSearchedFor) {
  TrackingState state = Tracking(1000);
  for (int ms = 2000; ms < 60'000; ms += 100) Scan(state, ms, false, 1.5);
  EXPECT_EQ(state.state(), LocalizationState::kLost);
  EXPECT_FALSE(state.IsLostForGood(StampAt(60'000)));
  Scan(state, 60'000, false, 2.1);
  EXPECT_FALSE(state.IsLostForGood(StampAt(61'000)));
  EXPECT_TRUE(state.IsLostForGood(StampAt(61'001)));
  for (int ms = 61'100; ms < 61'400; ms += 100) Scan(state, ms, true);
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
  EXPECT_FALSE(state.IsLostForGood(StampAt(70'000)));
}

TEST(TrackingStateTest, OneConfirmationAloneDoesNotEndBeingLost) {
  TrackingState state = Tracking(1000);
  for (int ms = 1100; ms <= 2500; ms += 100) Scan(state, ms, false);
  Scan(state, 2600, true);
  Scan(state, 2700, false);
  Scan(state, 2800, true);
  Scan(state, 2900, true);
  EXPECT_EQ(state.state(), LocalizationState::kLost);
  Scan(state, 3000, true);
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
}

TEST(TrackingStateTest, UncertainWhileTheMapConfirmsIsStillTracking) {
  TrackingState state = Tracking(1000);
  Scan(state, 1100, true, 3.0);
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
}

TEST(TrackingStateTest, ConfirmationsInARowRecoverFromBoth) {
  for (const double sigma_m : {0.5, 5.0}) {
    TrackingState state = Tracking(1000);
    Scan(state, 2000, false, sigma_m);
    EXPECT_NE(state.state(), LocalizationState::kTracking);
    Scan(state, 2100, true);
    Scan(state, 2200, true);
    EXPECT_NE(state.state(), LocalizationState::kTracking);
    Scan(state, 2300, true);
    EXPECT_EQ(state.state(), LocalizationState::kTracking);
  }
}

TEST(TrackingStateTest, WhoWasLostMustBeConfirmedAnew) {
  TrackingState state = Tracking(1000);
  // Silence, without a registration that could have failed.
  state.OnAnswer(StampAt(60'000), 30.0);
  EXPECT_EQ(state.state(), LocalizationState::kLost);
  Scan(state, 60'000, true);
  Scan(state, 60'100, true);
  EXPECT_EQ(state.state(), LocalizationState::kLost);
  Scan(state, 60'200, true);
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
}

// One second of registrations that contradict, from `ms` on, and then some that agree.
void Contradict(TrackingState& state, int ms) {
  for (const int end_ms = ms + 1000; ms <= end_ms; ms += 100) {
    state.OnRegistration(StampAt(ms), RegistrationOutcome::kOutlier);
    state.OnAnswer(StampAt(ms), 0.1);
  }
  EXPECT_EQ(state.state(), LocalizationState::kLost);
  for (const int end_ms = ms + 500; ms < end_ms; ms += 100) Scan(state, ms, true);
}

TEST(TrackingStateTest, WhoIsLostToContradictionsTwiceIsContradicted) {
  TrackingState state = Tracking(1000);
  Contradict(state, 1100);
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
  EXPECT_FALSE(state.IsContradicted());
  Contradict(state, 2700);
  EXPECT_TRUE(state.IsContradicted());
  state.StartFromGlobalSearch();
  EXPECT_FALSE(state.IsContradicted());
}

TEST(TrackingStateTest, ContradictionsFarApartAreTwoBursts) {
  TrackingState state = Tracking(1000);
  Contradict(state, 1100);
  for (int ms = 3000; ms < 20'000; ms += 100) Scan(state, ms, true);
  Contradict(state, 20'000);
  EXPECT_FALSE(state.IsContradicted());
}

TEST(TrackingStateTest, WhereTheMapIsEmptyNothingContradicts) {
  TrackingState state = Tracking(1000);
  for (const int begin_ms : {1100, 2700}) {
    for (int ms = begin_ms; ms <= begin_ms + 1000; ms += 100) Scan(state, ms, false);
    EXPECT_EQ(state.state(), LocalizationState::kLost);
    for (int ms = begin_ms + 1100; ms < begin_ms + 1600; ms += 100) Scan(state, ms, true);
  }
  EXPECT_FALSE(state.IsContradicted());
}

TEST(TrackingStateTest, ABlindStartIsConfirmedAnewAndThenTracks) {
  TrackingState state = Tracking(1000);
  state.StartFromGlobalSearch();
  EXPECT_EQ(state.state(), LocalizationState::kInitializing);
  Scan(state, 1100, true);
  Scan(state, 1200, true);
  EXPECT_EQ(state.state(), LocalizationState::kInitializing);
  Scan(state, 1300, true);
  EXPECT_EQ(state.state(), LocalizationState::kTracking);
}

TEST(TrackingStateTest, ABlindStartThatIsContradictedHasFailed) {
  StateOptions options = kOptions;
  options.global_start_max_refusals = 3;
  TrackingState state(options);
  state.StartFromGlobalSearch();
  Scan(state, 0, true);
  Scan(state, 100, false);
  Scan(state, 200, false);
  EXPECT_FALSE(state.GlobalStartFailed());
  Scan(state, 300, false);
  EXPECT_TRUE(state.GlobalStartFailed());
  EXPECT_FALSE(Tracking(1000).GlobalStartFailed());
}

}  // namespace
}  // namespace dcloc
