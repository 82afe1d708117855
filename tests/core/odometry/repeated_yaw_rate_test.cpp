#include "core/odometry/repeated_yaw_rate.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

EgoVelocity Reported(double speed_mps, double yaw_rate_radps) {
  return {.linear_mps = {speed_mps, 0.0, 0.0}, .angular_radps = {0.0, 0.0, yaw_rate_radps}};
}

TEST(RepeatedYawRateTest, OneThatIsTheSameAtEachSpeedIsRepeated) {
  RepeatedYawRate repeated;
  for (int i = 0; i < 10; ++i) repeated.OnReported(Reported(10.0 + 0.1 * i, 0.02));
  EXPECT_TRUE(repeated);
  repeated.OnReported(Reported(11.0, 0.021));
  EXPECT_FALSE(repeated);
}

TEST(RepeatedYawRateTest, AMessageThatIsReadTwiceIsNot) {
  RepeatedYawRate repeated;
  for (int i = 0; i < 10; ++i) repeated.OnReported(Reported(10.0, 0.02));
  EXPECT_FALSE(repeated);
}

TEST(RepeatedYawRateTest, AVehicleThatStandsRepeatsWhatIsTrue) {
  RepeatedYawRate repeated;
  for (int i = 0; i < 10; ++i) repeated.OnReported(Reported(0.001 * i, 0.0));
  EXPECT_FALSE(repeated);
}

}  // namespace
}  // namespace dcloc
