#include "core/geometry/rigid_fit.h"

#include <gtest/gtest.h>

#include <vector>

namespace dcloc {
namespace {

TEST(RigidFitTest, GivesTheMotionThatMadeThePairs) {
  const Pose2 T_a_b{{120.0, -7.5}, 2.9};
  std::vector<PlacePair> pairs;
  for (const Eigen::Vector2d& p_b_m :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(50.0, 3.0), Eigen::Vector2d(-20.0, 70.0)}) {
    pairs.push_back({T_a_b * p_b_m, p_b_m});
  }
  const Pose2 fit = FitRigid(pairs);
  EXPECT_NEAR((fit.translation_m - T_a_b.translation_m).norm(), 0.0, 1e-9);
  EXPECT_NEAR(fit.yaw_rad, T_a_b.yaw_rad, 1e-12);
}

TEST(RigidFitTest, SpreadsWhatDoesNotFit) {
  const std::vector<PlacePair> pairs = {{{0.0, 0.0}, {0.0, 0.0}}, {{10.2, 0.0}, {10.0, 0.0}}};
  const Pose2 fit = FitRigid(pairs);
  EXPECT_NEAR(fit.translation_m.x(), 0.1, 1e-12);
  EXPECT_NEAR(fit.yaw_rad, 0.0, 1e-12);
}

TEST(RigidFitTest, OnePairIsAShiftAndNoneNothing) {
  const std::vector<PlacePair> one = {{{3.0, 4.0}, {1.0, 1.0}}};
  EXPECT_EQ(FitRigid(one).translation_m, Eigen::Vector2d(2.0, 3.0));
  EXPECT_EQ(FitRigid(one).yaw_rad, 0.0);
  EXPECT_EQ(FitRigid({}).translation_m, Eigen::Vector2d::Zero());
}

}  // namespace
}  // namespace dcloc
