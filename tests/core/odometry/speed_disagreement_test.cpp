#include "core/odometry/speed_disagreement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr double kWheels_mps = 12.0;

class SpeedDisagreementTest : public ::testing::Test {
 protected:
  // Doppler says `apart_mps` more than the wheels for `count` scans of 75 ms.
  void Scans(int count, double apart_mps) {
    for (int i = 0; i < count; ++i) {
      disagreement_.OnSpeeds(stamp_, kWheels_mps, kWheels_mps + apart_mps);
      stamp_ += milliseconds(75);
    }
  }

  SpeedDisagreement disagreement_;
  Stamp stamp_{std::chrono::seconds(1'700'000'000)};
};

TEST(SpeedDisagreementOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<SpeedDisagreementOptions>();
}

TEST_F(SpeedDisagreementTest, SpeedsThatDifferAsUsualAreNoDisagreement) {
  Scans(100, 0.3);
  EXPECT_NEAR(disagreement_.distance_m(), 0.0, 1e-9);
}

TEST_F(SpeedDisagreementTest, AChangeAddsUpToTheDistance) {
  Scans(100, 0.0);
  Scans(7, 0.6);
  EXPECT_NEAR(disagreement_.distance_m(), 7 * 0.075 * 0.6, 0.06);
  Scans(300, -0.6);
  EXPECT_LT(disagreement_.distance_m(), 0.0);
}

TEST_F(SpeedDisagreementTest, WhatIsDecidedFades) {
  Scans(100, 0.0);
  Scans(10, 0.6);
  const double before_m = disagreement_.distance_m();
  for (int i = 0; i < 20; ++i) disagreement_.OnDecided(stamp_ += milliseconds(75));
  EXPECT_NEAR(disagreement_.distance_m() / before_m, std::exp(-20 * 0.075 / 1.5), 0.06);
}

TEST_F(SpeedDisagreementTest, ASilenceIsNoDistance) {
  Scans(100, 0.0);
  stamp_ += std::chrono::seconds(5);
  Scans(1, 0.6);
  EXPECT_NEAR(disagreement_.distance_m(), 0.0, 1e-3);
}

}  // namespace
}  // namespace dcloc
