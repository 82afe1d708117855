#include "core/odometry/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

EgoVelocity Turning(double t_s) {
  return {.linear_mps = {10.0 + 3.0 * t_s, 0.0, 0.0},
          .angular_radps = {0.0, 0.0, 0.4 * std::sin(2.0 * t_s)},
          .covariance = Matrix6d(Matrix6d::Zero())};
}

TEST(OdometryTest, TenScansFollowAFineIntegration) {
  Pose3 truth;
  constexpr int kSteps = 75'000;  // 10 us
  for (int i = 0; i < kSteps; ++i) {
    const EgoVelocity v = Turning((i + 0.5) * 1e-5);
    Vector6d twist;
    twist << v.linear_mps, v.angular_radps;
    truth = truth * Exp(Vector6d(twist * 1e-5));
  }
  Motion motion;
  for (int i = 0; i < 10; ++i) {
    motion = Compose(motion,
                     Integrate(Turning(i * 0.075), Turning((i + 1) * 0.075), milliseconds(75), {}));
  }
  EXPECT_LT(Log(truth.Inverse() * motion.T_from_to).norm(), 2e-3);
}

TEST(OdometryTest, TheSpreadIsThatOfDriftingVelocities) {
  // Velocity errors that hold for the correlation time and are then drawn again.
  const MotionOptions options{.correlation_time = milliseconds(500)};
  Vector6d sigmas;
  sigmas << 0.2, 0.1, 0.05, 0.002, 0.003, 0.02;
  EgoVelocity v{.linear_mps = {12.0, 0.0, 0.0}, .angular_radps = {0.0, 0.0, 0.2}};
  v.covariance = Matrix6d(sigmas.cwiseAbs2().asDiagonal());
  Motion motion;
  for (int i = 0; i < 60; ++i) {
    motion = Compose(motion, Integrate(v, v, milliseconds(100), options));
  }
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  Matrix6d sampled = Matrix6d::Zero();
  constexpr int kRuns = 4000;
  for (int run = 0; run < kRuns; ++run) {
    Pose3 pose;
    for (int step = 0; step < 12; ++step) {
      Vector6d twist;
      twist << v.linear_mps, v.angular_radps;
      for (int i = 0; i < 6; ++i) twist(i) += sigmas(i) * normal(random);
      pose = pose * Exp(Vector6d(twist * 0.5));
    }
    const Vector6d error = Log(motion.T_from_to.Inverse() * pose);
    sampled += error * error.transpose() / kRuns;
  }
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(motion.covariance(i, i) / sampled(i, i), 1.0, 0.12) << i;
  }
}

TEST(OdometryTest, AMissingCovarianceIsTheOptions) {
  const MotionOptions options{.linear_sigma_mps = 0.1};
  const EgoVelocity with = WithCovariance({.linear_mps = {10.0, 0.0, 0.0}}, 0.02, options);
  EXPECT_NEAR((*with.covariance)(0, 0), 0.09, 1e-12);
  const EgoVelocity own = {.covariance = Matrix6d(Matrix6d::Identity())};
  EXPECT_EQ(*WithCovariance(own, 0.02, options).covariance, Matrix6d::Identity());
}

}  // namespace
}  // namespace dcloc
