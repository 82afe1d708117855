#include "core/radar/measurement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dcloc {
namespace {

const Measurement kMeasurement{.range_m = 42.0,
                               .range_rate_mps = -9.0,
                               .elevation_rad = 0.1,
                               .azimuth_rad = -0.7,
                               .range_sigma_m = 0.2,
                               .range_rate_sigma_mps = 0.3,
                               .elevation_sigma_rad = 0.02,
                               .azimuth_sigma_rad = 0.01};
constexpr double kBeta_s = 0.04;

TEST(CompensatedRangeTest, AnApproachingTargetWasMeasuredTooNear) {
  EXPECT_NEAR(CompensatedRange(50.0, -10.0, 0.04), 50.4, 1e-12);
  EXPECT_NEAR(CompensatedRange(50.0, -10.0, -0.04), 49.6, 1e-12);
}

TEST(CompensatedRangeTest, UndoesThePhaseExactChirp) {
  // The beat frequency of an up-chirp from first principles: range and Doppler parts of the phase
  // 2 pi (f_c tau + K tau t - ...) with tau(t) = 2 (r + v t) / c, differentiated at the chirp's
  // middle; the measured range is the beat frequency times c / (2 K).
  constexpr double kLight_mps = 299792458.0;
  constexpr double kCarrier_hz = 76.5e9;
  const double slope_hz_per_s = kCarrier_hz / kBeta_s;
  const auto phase = [&](double t_s, double range_m, double rate_mps) {
    const double tau_s = 2.0 * (range_m + rate_mps * t_s) / kLight_mps;
    return kCarrier_hz * tau_s + slope_hz_per_s * tau_s * t_s -
           0.5 * slope_hz_per_s * tau_s * tau_s;
  };
  for (const double rate_mps : {-30.0, -10.0, 0.0, 10.0}) {
    const double h_s = 1e-7;
    const double beat_hz = (phase(h_s, 60.0, rate_mps) - phase(-h_s, 60.0, rate_mps)) / (2.0 * h_s);
    const double measured_m = beat_hz * kLight_mps / (2.0 * slope_hz_per_s);
    EXPECT_NEAR(CompensatedRange(measured_m, rate_mps, kBeta_s), 60.0, 1e-3) << rate_mps;
  }
}

TEST(UnfoldRangeRateTest, TakesTheAliasNearestToThePrediction) {
  EXPECT_NEAR(UnfoldRangeRate(3.0, -16.5, 10.0), -17.0, 1e-12);
  EXPECT_NEAR(UnfoldRangeRate(3.0, 2.0, 10.0), 3.0, 1e-12);
  EXPECT_EQ(UnfoldRangeRate(3.0, -100.0, 0.0), 3.0);
}

TEST(PredictedRangeRateTest, IsTheDerivativeOfTheRange) {
  Vector6d mount;
  mount << 3.4, -0.5, 0.6, 0.02, -0.05, 0.8;
  const Pose3 T_vehicle_radar = Exp(mount);
  Vector6d twist;
  twist << 12.0, 0.3, -0.1, 0.02, -0.03, 0.4;
  const EgoVelocity ego{.linear_mps = twist.head<3>(), .angular_radps = twist.tail<3>()};
  const Eigen::Vector3d target_vehicle(30.0, -12.0, 2.0);
  const auto range_m = [&](double t_s) {
    const Pose3 T_vehicle0_radar = Exp(Vector6d(twist * t_s)) * T_vehicle_radar;
    return (target_vehicle - T_vehicle0_radar.translation_m).norm();
  };
  const double truth_mps = (range_m(1e-5) - range_m(-1e-5)) / 2e-5;
  const Eigen::Vector3d u = (target_vehicle - T_vehicle_radar.translation_m).normalized();
  EXPECT_NEAR(PredictedRangeRate(u, T_vehicle_radar, ego), truth_mps, 1e-6);
}

TEST(PointJacobianTest, MatchesDifferences) {
  const Eigen::Matrix<double, 3, 4> jacobian = PointJacobian(kMeasurement, kBeta_s);
  double Measurement::*const fields[] = {&Measurement::range_m, &Measurement::range_rate_mps,
                                         &Measurement::elevation_rad, &Measurement::azimuth_rad};
  for (int column = 0; column < 4; ++column) {
    Measurement above = kMeasurement;
    Measurement below = kMeasurement;
    above.*fields[column] += 1e-6;
    below.*fields[column] -= 1e-6;
    const Eigen::Vector3d truth =
        (PointInRadar(above, kBeta_s) - PointInRadar(below, kBeta_s)) / 2e-6;
    EXPECT_LT((jacobian.col(column) - truth).norm(), 1e-6) << "column " << column;
  }
}

TEST(PointCovarianceTest, MatchesSampledPoints) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  constexpr int kSamples = 200'000;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kSamples; ++i) {
    Measurement sample = kMeasurement;
    sample.range_m += sample.range_sigma_m * normal(random);
    sample.range_rate_mps += sample.range_rate_sigma_mps * normal(random);
    sample.elevation_rad += sample.elevation_sigma_rad * normal(random);
    sample.azimuth_rad += sample.azimuth_sigma_rad * normal(random);
    const Eigen::Vector3d p = PointInRadar(sample, kBeta_s) - PointInRadar(kMeasurement, kBeta_s);
    sum += p;
    squares += p * p.transpose();
  }
  const Eigen::Vector3d mean = sum / kSamples;
  const Eigen::Matrix3d sampled = squares / kSamples - mean * mean.transpose();
  const Eigen::Matrix3d covariance = PointCovariance(kMeasurement, kBeta_s);
  EXPECT_LT((covariance - sampled).norm(), 0.02 * sampled.norm());
}

}  // namespace
}  // namespace dcloc
