#include "core/localizer/reset_counter.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

Pose3 At(double x_m, double y_m, double yaw_rad = 0.0) {
  return Embed(Pose2{.translation_m = {x_m, y_m}, .yaw_rad = yaw_rad});
}

TEST(ResetCounterTest, MotionAndSmallCorrectionsAreNoJumps) {
  ResetCounter counter({});
  counter.OnAnswer(At(5.0, 0.0));
  for (int i = 1; i < 20; ++i) {
    counter.OnMotion(At(1.0, 0.0));
    EXPECT_EQ(counter.OnAnswer(At(5.0 + i, 0.01 * i)), 0.0);
  }
  EXPECT_EQ(counter.resets().count, 0);
}

TEST(ResetCounterTest, AJumpIsCountedWithItsSize) {
  ResetCounter counter({});
  counter.OnAnswer(At(5.0, 0.0));
  counter.OnMotion(At(1.0, 0.0));
  EXPECT_NEAR(counter.OnAnswer(At(9.0, 4.0, 0.1)), 5.0, 1e-9);
  EXPECT_EQ(counter.resets().count, 1);
  const Pose3 without = At(6.0, 0.0);
  const Pose3 with = without * counter.resets().T_before_after;
  EXPECT_NEAR(with.translation_m.x(), 9.0, 1e-9);
  EXPECT_NEAR(with.translation_m.y(), 4.0, 1e-9);
  EXPECT_NEAR(Flatten(with).yaw_rad, 0.1, 1e-9);
}

TEST(ResetCounterTest, ATurnAloneIsAJump) {
  ResetCounter counter({});
  counter.OnAnswer(At(5.0, 0.0));
  counter.OnAnswer(At(5.0, 0.0, 0.05));
  EXPECT_EQ(counter.resets().count, 1);
}

}  // namespace
}  // namespace dcloc
