#include "core/localizer/tracking_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "core/localizer/tracking_state_machine.h"

namespace dcloc {
namespace {

constexpr std::array kModes = {
    TrackingMode::kSearching, TrackingMode::kConfirmingPrior, TrackingMode::kConfirmingPlace,
    TrackingMode::kConfirmed, TrackingMode::kSuspect,         TrackingMode::kDeadReckoning,
    TrackingMode::kLost,      TrackingMode::kContradicted,    TrackingMode::kRecovering};
constexpr std::array kEvents = {TrackingEvent::kPriorGiven,  TrackingEvent::kPlaceFound,
                                TrackingEvent::kVerified,    TrackingEvent::kDoubted,
                                TrackingEvent::kAgreed,      TrackingEvent::kConfirmed,
                                TrackingEvent::kHoldExpired, TrackingEvent::kLossExpired,
                                TrackingEvent::kLostAgain,   TrackingEvent::kGivenUp};
constexpr std::array kAgreements = {ScanAgreement::kDisagree, ScanAgreement::kAgree,
                                    ScanAgreement::kAgreeAndRegistered};
constexpr std::array kAgreementEvents = {ScanAgreementEvent::kDoesNotFit, ScanAgreementEvent::kFits,
                                         ScanAgreementEvent::kRegistrationAccepted};
constexpr std::array kRequirements = {
    ConfirmationRequirement::kRegistrations, ConfirmationRequirement::kRecoveredFitOrVerification,
    ConfirmationRequirement::kAgreeingFixOrVerification, ConfirmationRequirement::kVerification};
constexpr std::array kConfirmationEvents = {
    ConfirmationEvent::kMayBeElsewhere, ConfirmationEvent::kFitDeclines,
    ConfirmationEvent::kFitRecovers,    ConfirmationEvent::kFixesContradict,
    ConfirmationEvent::kFixAgrees,      ConfirmationEvent::kVerified};
constexpr std::array kWays = {AlongTrackObservability::kObserved, AlongTrackObservability::kFading,
                              AlongTrackObservability::kNotObserved,
                              AlongTrackObservability::kReturning};
constexpr std::array kWayEvents = {ObservabilityEvent::kSeen, ObservabilityEvent::kUnseen,
                                   ObservabilityEvent::kSeenForLong,
                                   ObservabilityEvent::kUnseenForLong};

// Each arrow is taken and stands once; every other event leaves every state as it is.
template <typename Table, typename States, typename Events>
void ExpectNothingElseMoves(const Table& table, const States& states, const Events& events) {
  std::size_t count = 0;
  for (const auto state : states) {
    for (const auto event : events) {
      const auto starts_here = [&](const auto& arrow) {
        return arrow.from == state && arrow.event == event;
      };
      const auto arrows = std::ranges::count_if(table, starts_here);
      ASSERT_LE(arrows, 1);
      count += static_cast<std::size_t>(arrows);
      const auto expected = arrows == 1 ? std::ranges::find_if(table, starts_here)->to : state;
      EXPECT_EQ(Next(state, event), expected);
    }
  }
  EXPECT_EQ(count, table.size());
}

template <typename Table, typename States>
void ExpectEachIsReachedAndLeft(const Table& table, const States& states) {
  for (const auto state : states) {
    EXPECT_TRUE(std::ranges::any_of(
        table, [&](const auto& arrow) { return arrow.to == state && arrow.from != state; }));
    EXPECT_TRUE(std::ranges::any_of(
        table, [&](const auto& arrow) { return arrow.from == state && arrow.to != state; }));
  }
}

TEST(TrackingStatesTest, ModesFollowTheirTable) {
  ExpectNothingElseMoves(kTrackingTransitions, kModes, kEvents);
  ExpectEachIsReachedAndLeft(kTrackingTransitions, kModes);
}

TEST(TrackingStatesTest, AgreementsFollowTheirTable) {
  ExpectNothingElseMoves(kScanAgreementTransitions, kAgreements, kAgreementEvents);
  ExpectEachIsReachedAndLeft(kScanAgreementTransitions, kAgreements);
}

TEST(TrackingStatesTest, WhatConfirmationRequiresFollowsItsTable) {
  ExpectNothingElseMoves(kConfirmationTransitions, kRequirements, kConfirmationEvents);
  ExpectEachIsReachedAndLeft(kConfirmationTransitions, kRequirements);
}

TEST(TrackingStatesTest, ObservationsOfTheWayFollowTheirTable) {
  ExpectNothingElseMoves(kObservabilityTransitions, kWays, kWayEvents);
  ExpectEachIsReachedAndLeft(kObservabilityTransitions, kWays);
}

// A pose is claimed only where it was confirmed, agreed or verified.
TEST(TrackingStatesTest, TrackingBeginsByThreeEventsOnly) {
  for (const TrackingTransition& arrow : kTrackingTransitions) {
    if (arrow.to != TrackingMode::kConfirmed) continue;
    EXPECT_TRUE(arrow.event == TrackingEvent::kConfirmed || arrow.event == TrackingEvent::kAgreed ||
                arrow.event == TrackingEvent::kVerified);
    EXPECT_NE(arrow.from, TrackingMode::kSearching);
    EXPECT_NE(arrow.from, TrackingMode::kConfirmingPrior);
    EXPECT_NE(arrow.from, TrackingMode::kRecovering);
  }
}

class TrackingTransitionTest : public ::testing::TestWithParam<TrackingTransition> {};

TEST_P(TrackingTransitionTest, IsTaken) {
  const TrackingTransition& arrow = GetParam();
  EXPECT_EQ(Next(arrow.from, arrow.event), arrow.to);
}

INSTANTIATE_TEST_SUITE_P(All, TrackingTransitionTest, ::testing::ValuesIn(kTrackingTransitions));

// What the trend of the scans' fits does to a pose.
void Accept(TrackingStateMachine& state, int count) {
  for (int i = 0; i < count; ++i) {
    state.OnRegistration(Stamp(std::chrono::milliseconds(1'000'000 + 10 * i)),
                         RegistrationOutcome::kAccepted);
  }
}

void Agree(TrackingStateMachine& state, int count) {
  for (int i = 0; i < count; ++i) state.OnScanFit(ScanFit::kAgrees);
}

TEST(TrackingDoubtTest, WhileScansFitLessThanBeforeThePoseIsDoubted) {
  TrackingStateMachine state({});
  state.OnPlaceFound();
  Accept(state, 5);
  ASSERT_EQ(state.mode(), TrackingMode::kConfirmed);
  state.OnFitTrend(FitTrend::kDeclined);
  Accept(state, 5);
  Agree(state, 5);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect);
  EXPECT_TRUE(state.ShouldSearchBeside());
  state.OnFitTrend(FitTrend::kUsual);
  Agree(state, 5);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

TEST(TrackingDoubtTest, ScansThatStillFitALittleLessDoNotEndIt) {
  TrackingStateMachine state({});
  state.OnPlaceFound();
  Accept(state, 5);
  state.OnFitTrend(FitTrend::kDeclining);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed) << "too little to doubt a pose";
  state.OnScanFit(ScanFit::kContradicts);
  Agree(state, 1);
  Accept(state, 1);
  Agree(state, 5);
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect);
  state.OnFitTrend(FitTrend::kUsual);
  Agree(state, 1);
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

TEST(TrackingDoubtTest, WhereTheGroundRepeatsOnlyVerificationEndsIt) {
  TrackingStateMachine state({});
  state.OnPlaceFound();
  Accept(state, 5);
  state.OnFitTrend(FitTrend::kDeclined, /*ground_repeats=*/true);
  state.OnFitTrend(FitTrend::kUsual, /*ground_repeats=*/true);
  Accept(state, 5);
  Agree(state, 5);
  EXPECT_TRUE(state.requires_verification());
  EXPECT_EQ(state.mode(), TrackingMode::kSuspect);
  state.OnVerified();
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

TEST(TrackingDoubtTest, VerificationEndsIt) {
  TrackingStateMachine state({});
  state.OnPlaceFound();
  Accept(state, 5);
  state.OnFitTrend(FitTrend::kDeclined);
  state.OnVerified();
  EXPECT_EQ(state.mode(), TrackingMode::kConfirmed);
}

TEST(TrackingDoubtTest, APriorThatSomethingContradictsHasNoLead) {
  TrackingStateMachine state({});
  EXPECT_FALSE(state.is_undoubted_prior());
  state.OnPrior();
  EXPECT_TRUE(state.is_undoubted_prior());
  state.OnFitTrend(FitTrend::kDeclined);
  EXPECT_FALSE(state.is_undoubted_prior());
}

}  // namespace
}  // namespace dcloc
