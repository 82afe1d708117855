#include "core/odometry/doppler_ego_velocity.h"

#include <gtest/gtest.h>

#include "tests/core/radar/scan_fixture.h"

namespace dcloc {
namespace {

EgoVelocity PlanarMotion(double speed_mps, double yaw_rate_radps) {
  return {.linear_mps = {speed_mps, 0.0, 0.0}, .angular_radps = {0.0, 0.0, yaw_rate_radps}};
}

void AddMovers(Scan& scan, int count, float range_rate_mps) {
  for (int i = 0; i < count; ++i) {
    scan.azimuth_rad.push_back(-0.5F + 1.0F * static_cast<float>(i) / static_cast<float>(count));
    scan.range_m.push_back(25.0F);
    scan.range_rate_mps.push_back(range_rate_mps);
  }
}

TEST(EgoVelocityTest, OneRadarWithoutNoiseIsExact) {
  const RadarModel radar = RadarAt("front", 3.6, 0.0, 0.05);
  const Scan scan = StaticScan(radar, PlanarMotion(13.0, 0.25), 60, 1, 0.0);
  const RadarScan scans[] = {{&scan, &radar}};
  const auto estimate = EstimateEgoVelocity(scans, 5);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->ego_velocity.linear_mps.x(), 13.0, 1e-3);
  EXPECT_NEAR(estimate->ego_velocity.linear_mps.y(), 0.0, 1e-3);
  EXPECT_NEAR(estimate->ego_velocity.angular_radps.z(), 0.25, 1e-3);
  EXPECT_EQ(estimate->inlier_count, 60);
}

TEST(EgoVelocityTest, MoversAreOutvoted) {
  const RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  Scan scan = StaticScan(radar, PlanarMotion(10.0, 0.0), 50, 2, 1.0);
  AddMovers(scan, 35, 3.0F);  // two cars ahead, receding
  const RadarScan scans[] = {{&scan, &radar}};
  const auto estimate = EstimateEgoVelocity(scans, 5);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->ego_velocity.linear_mps.x(), 10.0, 0.15);
  EXPECT_LE(estimate->inlier_count, 52);
  EXPECT_EQ(estimate->target_count, 85);
}

TEST(EgoVelocityTest, ARigObservesSideSlipAndTurning) {
  const RadarModel radars[] = {RadarAt("front", 3.6, 0.0, 0.0), RadarAt("left", 2.0, 0.9, 1.57),
                               RadarAt("rear", -1.0, -0.6, 3.14)};
  EgoVelocity truth = PlanarMotion(8.0, -0.3);
  truth.linear_mps.y() = 0.1;
  std::vector<Scan> scans;
  for (const RadarModel& radar : radars) scans.push_back(StaticScan(radar, truth, 60, 3, 0.0));
  const RadarScan rig[] = {
      {&scans[0], &radars[0]}, {&scans[1], &radars[1]}, {&scans[2], &radars[2]}};
  const auto estimate = EstimateEgoVelocity(rig, 9);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->ego_velocity.linear_mps.x(), 8.0, 0.01);
  EXPECT_NEAR(estimate->ego_velocity.linear_mps.y(), 0.1, 0.03);
  EXPECT_NEAR(estimate->ego_velocity.angular_radps.z(), -0.3, 0.01);
}

TEST(EgoVelocityTest, UnfoldsAliasedRangeRates) {
  RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  radar.unambiguous_range_rate_mps = 14.0;  // -18 m/s ahead is measured as +10
  const Scan scan = StaticScan(radar, PlanarMotion(18.0, 0.0), 80, 4, 0.5);
  const RadarScan scans[] = {{&scan, &radar}};
  const auto estimate = EstimateEgoVelocity(scans, 5);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->ego_velocity.linear_mps.x(), 18.0, 0.15);
}

TEST(EgoVelocityTest, StandingStillAmongMovers) {
  const RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  Scan scan = StaticScan(radar, PlanarMotion(0.0, 0.0), 50, 6, 0.3);
  AddMovers(scan, 20, -8.0F);
  const RadarScan scans[] = {{&scan, &radar}};
  const auto estimate = EstimateEgoVelocity(scans, 5);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_EQ(estimate->ego_velocity.linear_mps.norm(), 0.0);
}

TEST(EgoVelocityTest, SaysNothingWhereItCannotKnow) {
  const RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  Scan one_direction;
  for (int i = 0; i < 30; ++i) {
    one_direction.azimuth_rad.push_back(0.1F);
    one_direction.range_m.push_back(10.0F + static_cast<float>(i));
    one_direction.range_rate_mps.push_back(-9.0F);
  }
  const RadarScan narrow[] = {{&one_direction, &radar}};
  EXPECT_FALSE(EstimateEgoVelocity(narrow, 5).has_value());
  const Scan empty;
  const RadarScan nothing[] = {{&empty, &radar}};
  EXPECT_FALSE(EstimateEgoVelocity(nothing, 5).has_value());
}

// What a mount errs by is a share of the speed.
TEST(EgoVelocityTest, ItIsSurerOfAVehicleThatCreeps) {
  const RadarModel radar = RadarAt("front", 3.6, 0.3, 0.1);
  const auto sigma_mps = [&](double speed_mps) {
    const Scan scan = StaticScan(radar, PlanarMotion(speed_mps, 0.0), 80, /*seed=*/1, 0.6);
    const RadarScan scans[] = {{&scan, &radar}};
    const auto estimate = EstimateEgoVelocity(scans, /*seed=*/1);
    return std::sqrt((*estimate.value().ego_velocity.covariance)(0, 0));
  };
  EXPECT_LT(sigma_mps(0.6), 0.25);
  EXPECT_GT(sigma_mps(12.0), 0.5);
  EXPECT_LT(sigma_mps(30.0), 0.6);
}

TEST(EgoVelocityTest, TheCovarianceCoversTheErrors) {
  const RadarModel radar = RadarAt("front", 3.6, 0.3, 0.1);
  const EgoVelocityOptions options{.linear_sigma_floor_mps = 1e-6,
                                   .yaw_rate_sigma_floor_radps = 1e-6};
  double sum = 0.0;
  constexpr int kRuns = 300;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    const Scan scan = StaticScan(radar, PlanarMotion(12.0, 0.1), 80, seed, 0.6);
    const RadarScan scans[] = {{&scan, &radar}};
    const auto estimate = EstimateEgoVelocity(scans, seed, options);
    ASSERT_TRUE(estimate.has_value());
    const double error_mps = estimate->ego_velocity.linear_mps.x() - 12.0;
    sum += error_mps * error_mps / (*estimate->ego_velocity.covariance)(0, 0);
  }
  // Modelled with the azimuth's error and the full range rate deviation, of which the scans have
  // part: the covariance may be wide, it must not be narrow.
  EXPECT_LT(sum / kRuns, 1.0);
  EXPECT_GT(sum / kRuns, 0.05);
}

TEST(FuseTest, IsTheInformationWeightedMean) {
  EgoVelocity a = PlanarMotion(10.0, 0.1);
  EgoVelocity b = PlanarMotion(11.0, 0.3);
  a.covariance = Matrix6d(1.0 * Matrix6d::Identity());
  b.covariance = Matrix6d(3.0 * Matrix6d::Identity());
  const EgoVelocity fused = Fuse(a, b);
  EXPECT_NEAR(fused.linear_mps.x(), 10.25, 1e-12);
  EXPECT_NEAR(fused.angular_radps.z(), 0.15, 1e-12);
  EXPECT_NEAR((*fused.covariance)(0, 0), 0.75, 1e-12);
}

// It fills most of the view, but few directions.
TEST(EgoVelocityTest, AMoverAheadThatOutnumbersTheRestDoesNotWin) {
  const RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  Scan scan = StaticScan(radar, PlanarMotion(10.0, 0.0), 60, 2, 1.0);
  for (int i = 0; i < 120; ++i) {  // a truck, twenty degrees wide, as fast as we are
    scan.azimuth_rad.push_back(-0.17F + 0.34F * static_cast<float>(i) / 120.0F);
    scan.range_m.push_back(12.0F);
    scan.range_rate_mps.push_back(0.0F);
  }
  const RadarScan scans[] = {{&scan, &radar}};
  const auto estimate = EstimateEgoVelocity(scans, 5);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->ego_velocity.linear_mps.x(), 10.0, 0.2);
}

TEST(EgoVelocityTest, DirectionsAreThoseOfTheInliers) {
  const RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  const Scan scan = StaticScan(radar, PlanarMotion(10.0, 0.0), 200, 2, 1.0);
  const RadarScan scans[] = {{&scan, &radar}};
  const auto estimate = EstimateEgoVelocity(scans, 5);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_GE(estimate->direction_count, 8);
  EXPECT_LE(estimate->direction_count, 20);
}

TEST(EgoVelocityTest, CountsWhatAStandingVehicleWouldSee) {
  const RadarModel radar = RadarAt("front", 3.6, 0.0, 0.0);
  Scan scan = StaticScan(radar, PlanarMotion(4.0, 0.0), 200, 2, 1.0);
  const RadarScan scans[] = {{&scan, &radar}};
  auto estimate = EstimateEgoVelocity(scans, 5);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_GE(estimate->moving_direction_count, 8);
  EXPECT_EQ(estimate->standing_direction_count, 0);
  AddMovers(scan, 20, 0.0F);  // cars that keep their distance, or what stands still
  estimate = EstimateEgoVelocity(scans, 5);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_GE(estimate->standing_direction_count, 5);
}

}  // namespace
}  // namespace dcloc
