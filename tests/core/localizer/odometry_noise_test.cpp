#include "core/localizer/odometry_noise.h"

#include <gtest/gtest.h>

#include <random>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr double kOdometrySigma_m = 0.05;
constexpr double kOdometrySigma_rad = 0.004;
constexpr double kRegistrationSigma_m = 0.02;
constexpr double kRegistrationSigma_rad = 0.001;

Eigen::Matrix3d Diagonal(double sigma_m, double sigma_rad) {
  return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
}

// A vehicle at 1 m a step whose odometry varies `ratio` times as much, in deviations, as it says.
class Vehicle {
 public:
  explicit Vehicle(double ratio) : ratio_(ratio) {}

  void Step(OdometryNoise<2>& noise, const Eigen::Vector3d& registration_fault = {0.0, 0.0, 0.0}) {
    const Pose2 T_now_next = Exp(Eigen::Vector3d(1.0, 0.0, 0.02));
    T_map_vehicle_ = T_map_vehicle_ * T_now_next;
    ++step_;
    noise.OnMotion(
        {.pose = T_now_next * Exp(Draw(ratio_ * kOdometrySigma_m, ratio_ * kOdometrySigma_rad)),
         .covariance = Diagonal(kOdometrySigma_m, kOdometrySigma_rad)});
    noise.OnRegistration(
        Stamp(milliseconds(100 * step_)),
        {.pose = T_map_vehicle_ * Exp(Draw(kRegistrationSigma_m, kRegistrationSigma_rad)) *
                 Exp(registration_fault),
         .covariance = Diagonal(kRegistrationSigma_m, kRegistrationSigma_rad)},
        milliseconds(950));
  }

 private:
  Eigen::Vector3d Draw(double sigma_m, double sigma_rad) {
    return {sigma_m * normal_(random_), sigma_m * normal_(random_), sigma_rad * normal_(random_)};
  }

  double ratio_;
  Pose2 T_map_vehicle_;
  int step_ = 0;
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
};

// Of translation and rotation, as deviations.
Eigen::Vector2d LearnedRatio(const OdometryNoise<2>& noise) {
  const Eigen::Matrix3d learned = noise.Learned(Eigen::Matrix3d::Identity());
  return {std::sqrt(learned(0, 0)), std::sqrt(learned(2, 2))};
}

TEST(OdometryNoiseTest, BelievesTheModelAtFirst) {
  EXPECT_EQ(LearnedRatio(OdometryNoise<2>()), Eigen::Vector2d::Ones());
}

TEST(OdometryNoiseTest, LearnsHowMuchOdometryReallyVaries) {
  for (const double ratio : {0.3, 1.0, 2.0}) {
    OdometryNoise<2> noise;
    Vehicle vehicle(ratio);
    for (int step = 0; step < 3000; ++step) vehicle.Step(noise);
    EXPECT_NEAR(LearnedRatio(noise).x() / ratio, 1.0, 0.25) << ratio;
    EXPECT_NEAR(LearnedRatio(noise).y() / ratio, 1.0, 0.3) << ratio;
  }
}

TEST(OdometryNoiseTest, AFalseRegistrationCountsForLittle) {
  OdometryNoise<2> noise;
  Vehicle vehicle(1.0);
  for (int step = 0; step < 1000; ++step) vehicle.Step(noise);
  const Eigen::Vector2d before = LearnedRatio(noise);
  for (int step = 0; step < 12; ++step) vehicle.Step(noise, {50.0, 0.0, 0.5});
  EXPECT_LT(LearnedRatio(noise).x(), 1.4 * before.x());
  EXPECT_LT(LearnedRatio(noise).y(), 1.4 * before.y());
}

TEST(OdometryNoiseTest, WhatIsLearnedKeepsTheCorrelation) {
  OdometryNoise<2> noise;
  Vehicle vehicle(0.3);
  for (int step = 0; step < 300; ++step) vehicle.Step(noise);
  Eigen::Matrix3d covariance = Diagonal(0.1, 0.01);
  covariance(1, 2) = covariance(2, 1) = 0.5 * 0.1 * 0.01;
  const Eigen::Matrix3d learned = noise.Learned(covariance);
  EXPECT_NEAR(learned(1, 2) / std::sqrt(learned(1, 1) * learned(2, 2)), 0.5, 1e-12);
}

}  // namespace
}  // namespace dcloc
