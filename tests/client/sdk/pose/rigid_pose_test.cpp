#include "client/sdk/pose/rigid_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace dcloc::client {
namespace {

void ExpectNear(const Vector3& a, const Vector3& b, double tolerance = 1e-12) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << i;
}

TEST(RigidPoseTest, AConstantTwistDrivesACircle) {
  constexpr double kQuarter_rad = 0.5 * std::numbers::pi;
  const RigidPose end = Exp({10.0 * kQuarter_rad, 0.0, 0.0, 0.0, 0.0, kQuarter_rad});
  ExpectNear(end.translation_m, {10.0, 10.0, 0.0});
  ExpectNear(Rotate(end, {1.0, 0.0, 0.0}), {0.0, 1.0, 0.0});
}

TEST(RigidPoseTest, LogUndoesExp) {
  for (const double scale : {0.0, 1e-9, 1e-3, 1.0, 1.8}) {
    const Vector6 xi = scale * Vector6{3.0, -2.0, 0.5, 0.3, -0.2, 1.5};
    const Vector6 again = Log(Exp(xi));
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(again[i], xi[i], 1e-9) << scale << " " << i;
  }
}

TEST(RigidPoseTest, APoseTimesItsInverseIsNone) {
  const RigidPose T = Exp({3.0, -2.0, 0.5, 0.3, -0.2, 1.5});
  const RigidPose none = T * Inverse(T);
  ExpectNear(none.translation_m, {});
  EXPECT_NEAR(std::abs(none.rotation_wxyz[0]), 1.0, 1e-12);
}

TEST(RigidPoseTest, WhatIsNotKnownOfTheHeadingMovesWhatLiesAhead) {
  Matrix6 covariance{};
  covariance[35] = 0.01;  // heading
  const Matrix6 moved = MoveCovariance(covariance, {10.0, 0.0, 0.0});
  EXPECT_NEAR(moved[7], 1.0, 1e-12);   // y: 10 m * 0.1 rad
  EXPECT_NEAR(moved[0], 0.0, 1e-12);   // x
  EXPECT_NEAR(moved[11], 0.1, 1e-12);  // y with heading: both to the left
  EXPECT_NEAR(moved[31], 0.1, 1e-12);
  EXPECT_NEAR(moved[35], 0.01, 1e-12);
}

TEST(RigidPoseTest, AMovedCovarianceIsThatOfTheMovedPoses) {
  // The same by hand: J S J^T, with J = [I, M; 0, I] and M v = v x offset.
  const Vector3 offset = {3.0, -4.0, 1.0};
  Matrix6 J{};
  for (std::size_t i = 0; i < 6; ++i) J[7 * i] = 1.0;
  for (std::size_t j = 0; j < 3; ++j) {
    Vector3 unit{};
    unit[j] = 1.0;
    const Vector3 column = Cross(unit, offset);
    for (std::size_t i = 0; i < 3; ++i) J[6 * i + 3 + j] = column[i];
  }
  Matrix6 S{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      S[6 * i + j] = 1.0 / (1.0 + static_cast<double>(i + j)) + (i == j ? 1.0 : 0.0);
    }
  }
  const Matrix6 moved = MoveCovariance(S, offset);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      double expected = 0.0;
      for (std::size_t k = 0; k < 6; ++k) {
        for (std::size_t l = 0; l < 6; ++l) expected += J[6 * i + k] * S[6 * k + l] * J[6 * j + l];
      }
      EXPECT_NEAR(moved[6 * i + j], expected, 1e-9) << i << " " << j;
    }
  }
}

TEST(RigidPoseTest, VariancesLieAlongTheAxesOfThePose) {
  const RigidPose left = Exp({0.0, 0.0, 0.0, 0.0, 0.0, 0.5 * std::numbers::pi});
  Matrix6 covariance{};
  AddVariances(left, {4.0, 1.0, 0.0, 0.0, 0.0, 0.25}, covariance);
  EXPECT_NEAR(covariance[0], 1.0, 1e-12);
  EXPECT_NEAR(covariance[7], 4.0, 1e-12);
  EXPECT_NEAR(covariance[35], 0.25, 1e-12);
}

}  // namespace
}  // namespace dcloc::client
