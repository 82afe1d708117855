#include "client/simulation/radar/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "client/simulation/radar/radar_profile.h"

namespace dcloc::simulation {
namespace {

struct Moments {
  double mean, deviation, skewness, least;
};

Moments MomentsOf(const Noise& noise) {
  Random random = MakeRandom(11, Stream::kScan);
  constexpr int kCount = 400'000;
  std::vector<double> draws(kCount);
  for (double& draw : draws) draw = noise.Draw(random);
  double mean = 0.0;
  for (const double draw : draws) mean += draw / kCount;
  double second = 0.0;
  double third = 0.0;
  for (const double draw : draws) {
    second += std::pow(draw - mean, 2) / kCount;
    third += std::pow(draw - mean, 3) / kCount;
  }
  return {mean, std::sqrt(second), third / std::pow(second, 1.5),
          *std::min_element(draws.begin(), draws.end())};
}

void ExpectMoments(NoiseKind kind, double scale, double mean, double deviation, double skewness) {
  const Noise noise{kind, scale};
  const Moments moments = MomentsOf(noise);
  EXPECT_NEAR(moments.mean, mean, 0.01 * scale);
  EXPECT_NEAR(moments.deviation, deviation, 0.01 * scale);
  EXPECT_NEAR(moments.skewness, skewness, 0.1);
  EXPECT_NEAR(noise.Mean(), mean, 1e-3 * scale);
  EXPECT_NEAR(noise.StandardDeviation(), deviation, 1e-3 * scale);
}

TEST(NoiseTest, GaussianMoments) { ExpectMoments(NoiseKind::kGaussian, 0.25, 0.0, 0.25, 0.0); }

TEST(NoiseTest, GammaIsCentredAndSkewed) {
  ExpectMoments(NoiseKind::kGamma, 0.25, 0.0, 0.25, 2.0);
  EXPECT_GE(MomentsOf({NoiseKind::kGamma, 0.25}).least, -0.25);
}

TEST(NoiseTest, StudentMoments) {
  ExpectMoments(NoiseKind::kStudent, 0.25, 0.0, 0.25 * std::sqrt(100.0 / 98.0), 0.0);
}

TEST(NoiseTest, RayleighIsBiasedAndNeverNegative) {
  ExpectMoments(NoiseKind::kRayleigh, 0.5, 0.6267, 0.3276, 0.631);
  EXPECT_GE(MomentsOf({NoiseKind::kRayleigh, 0.5}).least, 0.0);
}

TEST(CarlaProfileTest, HasTheScalesOfTableFour) {
  constexpr double kDegree = 0.017453292519943295;
  const RadarProfile gaussian = CarlaProfile(NoiseKind::kGaussian);
  EXPECT_EQ(gaussian.range_m.scale, 0.25);
  EXPECT_NEAR(gaussian.azimuth_rad.scale, 0.5 * kDegree, 1e-12);
  EXPECT_EQ(gaussian.range_rate_mps.scale, 0.1);
  EXPECT_NEAR(CarlaProfile(NoiseKind::kGamma).azimuth_rad.scale, 0.025 * kDegree, 1e-12);
  const RadarProfile rayleigh = CarlaProfile(NoiseKind::kRayleigh);
  EXPECT_EQ(rayleigh.range_m.scale, 0.5);
  EXPECT_NEAR(rayleigh.azimuth_rad.scale, 1.0 * kDegree, 1e-12);
  EXPECT_EQ(rayleigh.range_rate_mps.scale, 0.1);
}

TEST(RigTest, IsValidAndSaysWhatTheProfileDoes) {
  const Rig rig = MakeRig(CarlaProfile(NoiseKind::kRayleigh), 5, 0.03, true, 40.0);
  ASSERT_EQ(rig.radars.size(), 5U);
  EXPECT_TRUE(Validate(rig).ok());
  EXPECT_TRUE(rig.MeasuresElevation());
  EXPECT_NEAR(rig.radars[0].range_sigma_m, 0.3276, 1e-3);
  EXPECT_EQ(rig.radars[0].beta_s, 0.03);
  EXPECT_EQ(rig.radars[0].unambiguous_range_rate_mps, 40.0);
  EXPECT_NEAR(Yaw(rig.Find("RADAR_FRONT_LEFT")->T_vehicle_radar.rotation), 1.5708, 1e-4);
}

}  // namespace
}  // namespace dcloc::simulation
