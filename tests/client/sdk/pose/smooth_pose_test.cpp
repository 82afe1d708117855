#include <gtest/gtest.h>

#include <cmath>

#include "client/sdk/pose/pose_tracker.h"
#include "tests/client/sdk/pose/answers.h"

namespace dcloc::client {
namespace {

/// A vehicle at 10 m/s whose wheels speak every 10 ms; asked for its pose each time.
class SmoothPoseTest : public ::testing::Test {
 protected:
  void Drive(int until_ms) {
    for (; now_ms_ < until_ms; now_ms_ += 10) {
      ASSERT_TRUE(poses_.AddVelocity(At(now_ms_), Driving(10.0)).ok());
    }
  }
  double Smooth(int ms) const { return Estimate(ms).T_map_vehicle.translation_m[1]; }
  PoseEstimate Estimate(int ms) const {
    const absl::StatusOr<PoseEstimate> estimate = poses_.SmoothPoseAt(At(ms));
    EXPECT_TRUE(estimate.ok()) << estimate.status();
    return estimate.value_or(PoseEstimate{});
  }
  double Raw(int ms) const { return poses_.PoseAt(At(ms))->T_map_vehicle.translation_m[1]; }
  int now_ms() const { return now_ms_; }

  PoseTracker poses_{{}};

 private:
  int now_ms_ = 0;
};

TEST_F(SmoothPoseTest, WithoutJumpsItIsTheSame) {
  Drive(10);
  poses_.AddAnswer(AnswerAt(0, 0.0));
  Drive(110);
  poses_.AddAnswer(AnswerAt(100, 1.0));
  EXPECT_NEAR(Estimate(150).T_map_vehicle.translation_m[0], 1.5, 1e-9);
  EXPECT_NEAR(Smooth(150), 0.0, 1e-9);
}

TEST_F(SmoothPoseTest, AJumpBleedsOffAtTheStatedRate) {
  Drive(10);
  poses_.AddAnswer(AnswerAt(0, 0.0));
  Drive(160);
  poses_.AddAnswer(AnswerAt(100, 1.0, 0.2));  // 0.2 m to the left, known 50 ms late
  EXPECT_NEAR(Raw(150), 0.2, 1e-9);
  EXPECT_NEAR(Smooth(150), 0.0, 1e-9);
  EXPECT_NEAR(Smooth(350), 0.1, 1e-9);  // 0.5 m/s
  EXPECT_NEAR(Smooth(550), 0.2, 1e-9);
  EXPECT_NEAR(Estimate(250).T_map_vehicle.translation_m[0], 2.5, 1e-9);
}

TEST_F(SmoothPoseTest, WhatIsLeftOfAJumpIsNotKnown) {
  Drive(10);
  poses_.AddAnswer(AnswerAt(0, 0.0));
  Drive(110);
  poses_.AddAnswer(AnswerAt(100, 1.0, 0.3));
  const double raw = poses_.PoseAt(At(100))->covariance[7];
  EXPECT_NEAR(Estimate(100).covariance[7], raw + 0.09, 1e-9);
}

TEST_F(SmoothPoseTest, NoStepIsLargerThanTheRateWhateverTheAnswersSay) {
  Drive(10);
  double last = 0.0;
  for (int ms = 0; ms < 3000; ms += 50) {
    // Answers that scatter by 10 cm and 2 degrees, each 40 ms late.
    poses_.AddAnswer(AnswerAt(ms, 0.01 * ms, 0.1 * std::sin(0.7 * ms), 0.03 * std::sin(0.3 * ms)));
    for (int step = 0; step < 5; ++step) {
      const int now = ms + 40 + 10 * step;
      Drive(now + 10);
      const double smooth = Smooth(now);
      // 10 ms at 0.5 m/s, and at 10 m/s in a direction that is 2 degrees off.
      EXPECT_LE(std::abs(smooth - last), 0.005 + 0.1 * 0.06) << now;
      last = smooth;
    }
  }
}

TEST_F(SmoothPoseTest, ALargeJumpIsFollowedAtOnce) {
  Drive(10);
  poses_.AddAnswer(AnswerAt(0, 0.0));
  Drive(110);
  poses_.AddAnswer(AnswerAt(100, 1.0, 20.0));
  EXPECT_NEAR(Smooth(100), 20.0, 1e-9);
}

TEST_F(SmoothPoseTest, ATurnBleedsOffToo) {
  Drive(10);
  poses_.AddAnswer(AnswerAt(0, 0.0));
  Drive(110);
  poses_.AddAnswer(AnswerAt(100, 1.0, 0.0, 0.02));
  const auto yaw = [&](int ms) {
    return 2.0 * std::asin(Estimate(ms).T_map_vehicle.rotation_wxyz[3]);
  };
  EXPECT_NEAR(yaw(100), 0.0, 1e-9);
  EXPECT_NEAR(yaw(300), 0.01, 1e-9);  // 0.05 rad/s
  EXPECT_NEAR(yaw(500), 0.02, 1e-9);
}

}  // namespace
}  // namespace dcloc::client
