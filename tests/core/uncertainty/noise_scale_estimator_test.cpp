#include "core/uncertainty/noise_scale_estimator.h"

#include <gtest/gtest.h>

#include <random>

namespace dcloc {
namespace {

constexpr double kOdometrySigma_m = 0.05;
constexpr double kOdometrySigma_rad = 0.004;
constexpr double kRegistrationSigma_m = 0.02;
constexpr double kRegistrationSigma_rad = 0.001;

Eigen::Matrix3d Diagonal(double sigma_m, double sigma_rad) {
  return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
}

// By how much more, in deviations, odometry and registrations vary than they say.
struct Ratios {
  double odometry = 1.0;
  double registrations = 1.0;
};

// A vehicle at 1 m a step.
class Vehicle {
 public:
  explicit Vehicle(const Ratios& ratios) : ratios_(ratios) {}

  void Step(NoiseScaleEstimator<2>& noise,
            const Eigen::Vector3d& registration_fault = {0.0, 0.0, 0.0}) {
    const Pose2 T_now_next = Exp(Eigen::Vector3d(1.0, 0.0, 0.02));
    T_map_vehicle_ = T_map_vehicle_ * T_now_next;
    ++step_;
    noise.OnMotion(
        {.pose = T_now_next * Draw(ratios_.odometry, kOdometrySigma_m, kOdometrySigma_rad),
         .covariance = Diagonal(kOdometrySigma_m, kOdometrySigma_rad)});
    if (step_ % 10 != 0) return;
    noise.OnRegistration(
        {.pose = T_map_vehicle_ *
                 Draw(ratios_.registrations, kRegistrationSigma_m, kRegistrationSigma_rad) *
                 Exp(registration_fault),
         .covariance = Diagonal(kRegistrationSigma_m, kRegistrationSigma_rad)});
  }

 private:
  Pose2 Draw(double ratio, double sigma_m, double sigma_rad) {
    const double x = normal_(random_);
    const double y = normal_(random_);
    return Exp(Eigen::Vector3d(ratio * sigma_m * x, ratio * sigma_m * y,
                               ratio * sigma_rad * normal_(random_)));
  }

  Ratios ratios_;
  Pose2 T_map_vehicle_;
  int step_ = 0;
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
};

// Of translation and rotation, as deviations.
Eigen::Vector2d Deviations(const Eigen::Matrix3d& learned) {
  return {std::sqrt(learned(0, 0)), std::sqrt(learned(2, 2))};
}
Eigen::Vector2d OdometryRatio(const NoiseScaleEstimator<2>& noise) {
  return Deviations(noise.OdometryCovariance(Eigen::Matrix3d::Identity()));
}
Eigen::Vector2d RegistrationRatio(const NoiseScaleEstimator<2>& noise) {
  return Deviations(noise.RegistrationCovariance(Eigen::Matrix3d::Identity()));
}

// What is learned over a long drive, the mean of what it says on the way.
Ratios LearnedOverADrive(const Ratios& truth, bool of_rotation) {
  NoiseScaleEstimator<2> noise;
  Vehicle vehicle(truth);
  for (int step = 0; step < 1000; ++step) vehicle.Step(noise);
  Ratios sum{0.0, 0.0};
  constexpr int kSteps = 6000;
  for (int step = 0; step < kSteps; ++step) {
    vehicle.Step(noise);
    sum.odometry += OdometryRatio(noise)(of_rotation ? 1 : 0) / kSteps;
    sum.registrations += RegistrationRatio(noise)(of_rotation ? 1 : 0) / kSteps;
  }
  return sum;
}

TEST(NoiseScaleEstimatorTest, StartsWithTheModelOfOdometry) {
  EXPECT_EQ(OdometryRatio(NoiseScaleEstimator<2>()), Eigen::Vector2d::Ones());
}

TEST(NoiseScaleEstimatorTest, LearnsHowMuchOdometryReallyVaries) {
  for (const double ratio : {0.3, 1.0, 2.0}) {
    for (const bool of_rotation : {false, true}) {
      const Ratios learned =
          LearnedOverADrive({.odometry = ratio, .registrations = 1.5}, of_rotation);
      EXPECT_NEAR(learned.odometry / ratio, 1.0, 0.2) << ratio << of_rotation;
    }
  }
}

TEST(NoiseScaleEstimatorTest, LearnsThatOdometryIsFarBetter) {
  for (const bool of_rotation : {false, true}) {
    EXPECT_LT(LearnedOverADrive({.odometry = 0.03, .registrations = 1.5}, of_rotation).odometry,
              0.1);
  }
}

// They describe odometry before its constant errors were known.
TEST(NoiseScaleEstimatorTest, TheFirstPairsSoonFade) {
  NoiseScaleEstimator<2> noise;
  Vehicle worse({.odometry = 2.0});
  for (int step = 0; step < 150; ++step) worse.Step(noise);
  EXPECT_GT(OdometryRatio(noise).x(), 1.0);
  noise.OnDiscontinuity();
  Vehicle better({.odometry = 0.1});
  for (int step = 0; step < 400; ++step) better.Step(noise);
  EXPECT_LT(OdometryRatio(noise).x(), 0.6);
}

TEST(NoiseScaleEstimatorTest, LearnsHowMuchRegistrationsReallyVary) {
  for (const double ratio : {2.0, 4.0}) {
    for (const bool of_rotation : {false, true}) {
      const Ratios learned =
          LearnedOverADrive({.odometry = 0.15, .registrations = ratio}, of_rotation);
      EXPECT_NEAR(learned.registrations / ratio, 1.0, 0.2) << ratio << of_rotation;
    }
  }
}

TEST(NoiseScaleEstimatorTest, AFalseRegistrationCountsForLittle) {
  NoiseScaleEstimator<2> noise;
  Vehicle vehicle({});
  for (int step = 0; step < 1000; ++step) vehicle.Step(noise);
  const Eigen::Vector2d before = OdometryRatio(noise);
  for (int step = 0; step < 12; ++step) vehicle.Step(noise, {50.0, 0.0, 0.5});
  EXPECT_LT(OdometryRatio(noise).x(), 1.5 * before.x());
  EXPECT_LT(OdometryRatio(noise).y(), 1.5 * before.y());
}

TEST(NoiseScaleEstimatorTest, AJumpIsNoNoise) {
  NoiseScaleEstimator<2> noise;
  Vehicle vehicle({});
  for (int step = 0; step < 1000; ++step) vehicle.Step(noise);
  const Eigen::Vector2d before = OdometryRatio(noise);
  noise.OnDiscontinuity();
  for (int step = 0; step < 50; ++step) vehicle.Step(noise, {500.0, 0.0, 0.0});
  EXPECT_LT((OdometryRatio(noise) - before).norm(), 0.5);
}

TEST(NoiseScaleEstimatorTest, OdometryWeighsByTwiceItsNoiseWithinBounds) {
  NoiseScaleEstimator<2> noise;
  EXPECT_EQ(Deviations(noise.OdometryWeightCovariance(Eigen::Matrix3d::Identity())),
            Eigen::Vector2d::Ones());
  Vehicle good({.odometry = 0.5});
  for (int step = 0; step < 1000; ++step) good.Step(noise);
  const Eigen::Vector2d ratio = OdometryRatio(noise);
  const Eigen::Vector2d weight =
      Deviations(noise.OdometryWeightCovariance(Eigen::Matrix3d::Identity()));
  EXPECT_NEAR((weight - std::sqrt(2.0) * ratio).norm(), 0.0, 1e-9);
  Vehicle perfect({.odometry = 0.01});
  for (int step = 0; step < 2000; ++step) perfect.Step(noise);
  EXPECT_LT(OdometryRatio(noise).maxCoeff(), 0.22);
  EXPECT_NEAR(noise.OdometryWeightCovariance(Eigen::Matrix3d::Identity())(0, 0), 0.1, 1e-12);
}

TEST(NoiseScaleEstimatorTest, WhatIsLearnedKeepsTheCorrelation) {
  NoiseScaleEstimator<2> noise;
  Vehicle vehicle({.odometry = 0.3});
  for (int step = 0; step < 300; ++step) vehicle.Step(noise);
  Eigen::Matrix3d covariance = Diagonal(0.1, 0.01);
  covariance(1, 2) = covariance(2, 1) = 0.5 * 0.1 * 0.01;
  const Eigen::Matrix3d learned = noise.OdometryCovariance(covariance);
  EXPECT_NEAR(learned(1, 2) / std::sqrt(learned(1, 1) * learned(2, 2)), 0.5, 1e-12);
}

}  // namespace
}  // namespace dcloc
