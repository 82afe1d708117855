#include "core/odometry/motion_history.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

Stamp MomentAt(int ms) { return Stamp(milliseconds(1'000'000 + ms)); }

// A vehicle at 10 m/s that turns, seen every 50 ms.
Motion Step() {
  Vector6d xi = Vector6d::Zero();
  xi(0) = 0.5;
  xi(5) = 0.02;
  return {.T_from_to = Exp(xi), .covariance = 1e-4 * Matrix6d::Identity()};
}

MotionHistory Driven(int count) {
  MotionHistory history(milliseconds(400));
  for (int i = 0; i < count; ++i) {
    history.Add(MomentAt(50 * i), Step(), {.linear_mps = {0.1 * i, 0.0, 0.0}});
  }
  return history;
}

TEST(MotionHistoryTest, AtAStampItGivesTheWholeSteps) {
  const MotionHistory history = Driven(11);
  const auto moment = history.At(MomentAt(400));
  ASSERT_TRUE(moment.has_value());
  const Pose3 expected = Step().T_from_to * Step().T_from_to;
  EXPECT_LT((moment->to_newest.T_from_to.translation_m - expected.translation_m).norm(), 1e-12);
  EXPECT_NEAR(moment->velocity.linear_mps.x(), 0.8, 1e-12);
}

TEST(MotionHistoryTest, BetweenTwoStampsItGivesAShare) {
  const auto moment = Driven(11).At(MomentAt(475));
  ASSERT_TRUE(moment.has_value());
  EXPECT_NEAR(moment->to_newest.T_from_to.translation_m.x(), 0.25, 1e-4);
  EXPECT_NEAR(Yaw(moment->to_newest.T_from_to.rotation), 0.01, 1e-9);
  EXPECT_NEAR(moment->to_newest.covariance(0, 0), 0.5e-4, 1e-12);
}

TEST(MotionHistoryTest, AtTheNewestStampNothingIsLeft) {
  const auto moment = Driven(11).At(MomentAt(500));
  ASSERT_TRUE(moment.has_value());
  EXPECT_EQ(moment->to_newest.T_from_to.translation_m, Eigen::Vector3d::Zero());
}

TEST(MotionHistoryTest, BeforeAndAfterItKnowsNothing) {
  const MotionHistory history = Driven(21);
  EXPECT_FALSE(history.At(MomentAt(1001)).has_value());
  EXPECT_FALSE(history.At(MomentAt(500)).has_value()) << "too long ago";
  EXPECT_TRUE(history.At(MomentAt(650)).has_value());
  EXPECT_FALSE(MotionHistory(milliseconds(400)).At(MomentAt(0)).has_value());
}

TEST(MotionHistoryTest, TheTwoPartsOfAMotionAreTheWhole) {
  const auto [first, rest] = Split(Step(), 0.3);
  const Pose3 whole = first.T_from_to * rest.T_from_to;
  EXPECT_LT((whole.translation_m - Step().T_from_to.translation_m).norm(), 1e-12);
  EXPECT_NEAR(first.covariance(0, 0) + rest.covariance(0, 0), 1e-4, 1e-15);
}

}  // namespace
}  // namespace dcloc
