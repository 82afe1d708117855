#include "core/odometry/forward_acceleration.h"

#include <gtest/gtest.h>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

const Stamp kBegin{std::chrono::seconds(1'700'000'000)};

// Of a vehicle that speeds up by `mps2` for three seconds.
ForwardAcceleration After(double mps2) {
  ForwardAcceleration acceleration;
  for (int i = 0; i < 200; ++i) {
    acceleration.OnSpeed(kBegin + i * milliseconds(15), 10.0 + mps2 * 0.015 * i);
  }
  return acceleration;
}

TEST(ForwardAccelerationOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<ForwardAccelerationOptions>();
}

TEST(ForwardAccelerationTest, TellsBySpeedsOfLate) {
  EXPECT_EQ(ForwardAcceleration().Gain_mps(milliseconds(40)), 0.0);
  EXPECT_NEAR(After(-3.0).Gain_mps(milliseconds(40)), -0.12, 0.005);
  EXPECT_NEAR(After(-3.0).Gain_mps(milliseconds(-40)), 0.12, 0.005);
}

TEST(ForwardAccelerationTest, NoVehicleIsThatFast) {
  EXPECT_NEAR(After(100.0).Gain_mps(milliseconds(40)), 0.48, 1e-9);
}

TEST(ForwardAccelerationTest, AfterASilenceNothingIsKnown) {
  ForwardAcceleration acceleration = After(3.0);
  acceleration.OnSpeed(kBegin + std::chrono::seconds(10), 10.0);
  EXPECT_EQ(acceleration.Gain_mps(milliseconds(40)), 0.0);
}

}  // namespace
}  // namespace dcloc
