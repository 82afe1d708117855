#include "client/load/vehicle_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace dcloc::load {
namespace {

constexpr std::array kRunStates = {VehicleState::kDriving, VehicleState::kFinishing,
                                   VehicleState::kCancelled, VehicleState::kDone};
constexpr std::array kStreamStates = {StreamState::kOpening, StreamState::kReopening,
                                      StreamState::kOpen, StreamState::kCut, StreamState::kClosing};

/// The states that `event` leads to, from each state in order.
template <typename States, typename Event>
auto StatesAfter(const States& states, Event event) {
  std::vector<typename States::value_type> after;
  after.reserve(states.size());
  for (const auto state : states) after.push_back(Next(state, event));
  return after;
}

TEST(VehicleStateTest, AFinishedRunCanBeCancelledButNotTheOtherWayRound) {
  using enum VehicleState;
  EXPECT_THAT(StatesAfter(kRunStates, VehicleEvent::kFinish),
              ::testing::ElementsAre(kFinishing, kFinishing, kCancelled, kDone));
  EXPECT_THAT(StatesAfter(kRunStates, VehicleEvent::kCancel),
              ::testing::ElementsAre(kCancelled, kCancelled, kCancelled, kDone));
}

TEST(VehicleStateTest, OnlyARunThatIsToEndIsDone) {
  using enum VehicleState;
  EXPECT_THAT(StatesAfter(kRunStates, VehicleEvent::kEnd),
              ::testing::ElementsAre(kDriving, kDone, kDone, kDone));
}

TEST(VehicleStateTest, AStreamOpensOnce) {
  using enum StreamState;
  EXPECT_THAT(StatesAfter(kStreamStates, StreamEvent::kOpened),
              ::testing::ElementsAre(kOpen, kOpen, kOpen, kCut, kClosing));
}

TEST(VehicleStateTest, OnlyAnOpenStreamIsCutOrClosed) {
  using enum StreamState;
  EXPECT_THAT(StatesAfter(kStreamStates, StreamEvent::kCut),
              ::testing::ElementsAre(kOpening, kReopening, kCut, kCut, kClosing));
  EXPECT_THAT(StatesAfter(kStreamStates, StreamEvent::kClose),
              ::testing::ElementsAre(kOpening, kReopening, kClosing, kCut, kClosing));
}

TEST(VehicleStateTest, ACutIsRememberedUntilTheSessionIsOpenAgain) {
  using enum StreamState;
  EXPECT_THAT(StatesAfter(kStreamStates, StreamEvent::kBegin),
              ::testing::ElementsAre(kOpening, kReopening, kOpening, kReopening, kOpening));
  std::vector<bool> opened;
  std::vector<bool> after_cut;
  for (const StreamState state : kStreamStates) {
    opened.push_back(WasOpened(state));
    after_cut.push_back(FollowsCut(state));
  }
  EXPECT_THAT(opened, ::testing::ElementsAre(false, false, true, true, true));
  EXPECT_THAT(after_cut, ::testing::ElementsAre(false, true, false, true, false));
}

}  // namespace
}  // namespace dcloc::load
