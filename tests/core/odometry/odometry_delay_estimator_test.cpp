#include "core/odometry/odometry_delay_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace dcloc {
namespace {

using Signal = std::function<double(double t_s)>;

double WeavingSpeed(double t_s) { return 11.0 + 2.0 * std::sin(0.5 * t_s) + std::sin(1.3 * t_s); }
double WeavingYawRate(double t_s) { return 0.15 * std::sin(0.4 * t_s); }

// How a vehicle moves, and how it reports that.
struct ReportedDrive {
  Signal speed_mps = WeavingSpeed;
  Signal yaw_rate_radps = WeavingYawRate;
  double delay_s = 0.0;
  double scale = 1.0;
  double bias_radps = 0.0;
  int period_ms = 75;
};

std::optional<ScalarEstimate> DelayAfter(double duration_s, const ReportedDrive& drive) {
  OdometryDelayEstimator estimator({});
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  for (int ms = 0; ms < 1000.0 * duration_s; ms += drive.period_ms) {
    const double t_s = 1e-3 * ms;
    const Stamp stamp{std::chrono::milliseconds(ms)};
    const double doppler_mps = drive.speed_mps(t_s) + 0.05 * normal(random);
    const double doppler_radps = drive.yaw_rate_radps(t_s) + 0.015 * normal(random);
    estimator.OnDoppler(stamp, doppler_mps, doppler_radps);
    const double then_s = t_s - drive.delay_s;
    const double reported_mps = drive.scale * drive.speed_mps(then_s) + 0.02 * normal(random);
    const double reported_radps =
        drive.yaw_rate_radps(then_s) + drive.bias_radps + 0.001 * normal(random);
    estimator.OnReported(stamp, reported_mps, reported_radps);
  }
  return estimator.delay_s();
}

TEST(OdometryDelayEstimatorTest, FindsTheDelay) {
  for (const double delay_s : {0.05, 0.1, 0.17, 0.3}) {
    const auto found = DelayAfter(25.0, {.delay_s = delay_s});
    ASSERT_TRUE(found) << delay_s;
    EXPECT_NEAR(found->value, delay_s, 0.015);
    EXPECT_LT(std::sqrt(found->variance), 0.02);
  }
}

TEST(OdometryDelayEstimatorTest, ScansThatAreStampedLateAreNoEarlyVelocity) {
  EXPECT_FALSE(DelayAfter(40.0, {.delay_s = -0.1}));
  OdometryDelayEstimator with_prior({});
  with_prior.Restore({-0.1, 1e-4});
  EXPECT_FALSE(with_prior.delay_s());
}

// Doppler errs by a wave of four seconds that looks like a late yaw rate for a while.
TEST(OdometryDelayEstimatorTest, ErrorsThatLastInformLess) {
  const auto delay_after = [](double duration_s, double error_radps, std::uint32_t seed) {
    OdometryDelayEstimator estimator({});
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    double error = 0.0;
    bool found = false;
    for (int ms = 0; ms < 1000.0 * duration_s; ms += 75) {
      const double t_s = 1e-3 * ms;
      const Stamp stamp{std::chrono::milliseconds(ms)};
      error = 0.95 * error + std::sqrt(1.0 - 0.95 * 0.95) * error_radps * normal(random);
      estimator.OnDoppler(stamp, 11.0, 0.05 * std::sin(0.4 * t_s) + error);
      estimator.OnReported(stamp, 11.0, 0.05 * std::sin(0.4 * t_s) + 0.001 * normal(random));
      found = found || estimator.delay_s();
    }
    return found;
  };
  int found = 0;
  for (std::uint32_t seed = 1; seed <= 50; ++seed) found += delay_after(60.0, 0.03, seed) ? 1 : 0;
  EXPECT_LE(found, 1);
}

TEST(OdometryDelayEstimatorTest, FindsNoneWhereThereIsNone) {
  for (const int period_ms : {15, 50, 75, 100}) {
    EXPECT_FALSE(DelayAfter(40.0, {.period_ms = period_ms})) << period_ms;
  }
}

TEST(OdometryDelayEstimatorTest, NeitherScaleNorBiasIsADelay) {
  EXPECT_FALSE(DelayAfter(40.0, {.scale = 1.3, .bias_radps = 0.05}));
  const auto found = DelayAfter(25.0, {.delay_s = 0.2, .scale = 0.7, .bias_radps = -0.05});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->value, 0.2, 0.015);
}

TEST(OdometryDelayEstimatorTest, ASteadyDriveShowsNoDelay) {
  const ReportedDrive drive{.speed_mps = [](double) { return 25.0; },
                            .yaw_rate_radps = [](double) { return 0.0; },
                            .delay_s = 0.3};
  EXPECT_FALSE(DelayAfter(60.0, drive));
}

TEST(OdometryDelayEstimatorTest, ADelayBeyondTheComparedOnesIsNotReported) {
  EXPECT_FALSE(DelayAfter(40.0, {.delay_s = 0.9}));
}

TEST(OdometryDelayEstimatorTest, ItFollowsAVehicleThatMendsItself) {
  OdometryDelayEstimator estimator({});
  for (int ms = 0; ms < 120'000; ms += 75) {
    const double t_s = 1e-3 * ms;
    const double delay_s = ms < 40'000 ? 0.2 : 0.0;
    const Stamp stamp{std::chrono::milliseconds(ms)};
    estimator.OnDoppler(stamp, WeavingSpeed(t_s), WeavingYawRate(t_s));
    estimator.OnReported(stamp, WeavingSpeed(t_s - delay_s), WeavingYawRate(t_s - delay_s));
    if (ms == 39'975) {
      EXPECT_TRUE(estimator.delay_s());
    }
  }
  EXPECT_FALSE(estimator.delay_s());
}

TEST(OdometryDelayEstimatorTest, StampsThatStandStillAreNoHarm) {
  OdometryDelayEstimator estimator({});
  for (int i = 0; i < 5000; ++i) {
    estimator.OnDoppler(Stamp{std::chrono::seconds(1)}, i % 7, 0.1);
    estimator.OnReported(Stamp{std::chrono::seconds(1)}, i % 5, 0.1);
  }
  EXPECT_FALSE(estimator.delay_s());
}

TEST(OdometryDelayEstimatorTest, ItsOptionsAreBounded) {
  EXPECT_TRUE(Validate(OdometryDelayOptions{}).ok());
  EXPECT_FALSE(Validate(OdometryDelayOptions{.latest_steps = 0}).ok());
  EXPECT_FALSE(Validate(OdometryDelayOptions{.speed_floor_mps = std::nan("")}).ok());
}

}  // namespace
}  // namespace dcloc
