#include "client/evaluation/faults/velocity_faults.h"

#include <gtest/gtest.h>

#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

const Window kSecond = {MadeStamp(1.0), MadeStamp(2.0)};

/// Checks that within the window the speed and the yaw rate are what `expected` says of the true
/// ones, and outside what they were.
template <typename Expected>
void ExpectVelocities(const Stream& stream, const Window& window, const Expected& expected) {
  const Stream before = MadeStream(3.0);
  ASSERT_EQ(stream.scans.size(), before.scans.size());
  std::size_t changed = 0;
  for (std::size_t i = 0; i < stream.scans.size(); ++i) {
    const EgoVelocity& was = *before.scans[i].scan.ego_velocity;
    const EgoVelocity& is = *stream.scans[i].scan.ego_velocity;
    Eigen::Vector2d wanted(was.linear_mps.x(), was.angular_radps.z());
    if (window.Contains(stream.scans[i].measured)) {
      wanted = expected(wanted);
      ++changed;
    }
    EXPECT_NEAR(is.linear_mps.x(), wanted.x(), 1e-9) << i;
    EXPECT_NEAR(is.angular_radps.z(), wanted.y(), 1e-9) << i;
  }
  EXPECT_EQ(changed, 10U);
}

TEST(VelocityFaultsTest, ScaleSpeedAndTurnApart) {
  Stream stream = MadeStream(3.0);
  ScaleVelocity(stream, kSecond, 0.5, -1.0);
  ExpectVelocities(stream, kSecond, [](const Eigen::Vector2d& was) {
    return Eigen::Vector2d(0.5 * was.x(), -was.y());
  });
}

TEST(VelocityFaultsTest, RaiseTheSpeedSlowly) {
  Stream stream = MadeStream(3.0);
  const Stream before = MadeStream(3.0);
  RampSpeed(stream, {MadeStamp(1.0)}, 0.9, 1.0);
  const auto factor = [&](std::size_t i) {
    return stream.scans[i].scan.ego_velocity->linear_mps.x() /
           before.scans[i].scan.ego_velocity->linear_mps.x();
  };
  EXPECT_NEAR(factor(5), 1.0, 1e-9);
  EXPECT_NEAR(factor(15), 0.95, 1e-9);
  EXPECT_NEAR(factor(25), 0.9, 1e-9);
}

TEST(VelocityFaultsTest, FreezeWhatWasLastSaid) {
  Stream stream = MadeStream(3.0);
  FreezeVelocity(stream, kSecond);
  ExpectVelocities(stream, kSecond,
                   [](const Eigen::Vector2d&) { return Eigen::Vector2d(10.09, 0.009); });
}

TEST(VelocityFaultsTest, BiasTheYawRate) {
  Stream stream = MadeStream(3.0);
  BiasYawRate(stream, kSecond, -0.2);
  ExpectVelocities(stream, kSecond, [](const Eigen::Vector2d& was) {
    return Eigen::Vector2d(was.x(), was.y() - 0.2);
  });
}

TEST(VelocityFaultsTest, RoundToStepsAndSayNothingOfASlowVehicle) {
  Stream stream = MadeStream(3.0);
  RoundVelocity(stream, kSecond, 0.5, 1.0, 0.02);
  ExpectVelocities(stream, kSecond, [](const Eigen::Vector2d& was) {
    return Eigen::Vector2d(0.5 * std::round(was.x() / 0.5), 0.02 * std::round(was.y() / 0.02));
  });
  RoundVelocity(stream, kSecond, 0.5, 50.0, 0.02);
  for (const StreamScan& entry : stream.scans) {
    EXPECT_EQ(entry.scan.ego_velocity->linear_mps.x() == 0.0, kSecond.Contains(entry.measured));
  }
}

TEST(VelocityFaultsTest, TakeTheSignOfReversing) {
  Drive drive = Reversed(MadeDrive(1.0));
  Stream stream = StreamOf(drive, {});
  EXPECT_LT(stream.scans[3].scan.ego_velocity->linear_mps.x(), -9.0);
  UnsignSpeed(stream, {MadeStamp(0.5)});
  EXPECT_LT(stream.scans[3].scan.ego_velocity->linear_mps.x(), -9.0);
  EXPECT_GT(stream.scans[6].scan.ego_velocity->linear_mps.x(), 9.0);
  EXPECT_LT(stream.scans[6].scan.ego_velocity->angular_radps.z(), 0.0);
}

TEST(VelocityFaultsTest, TellWhatWasSoBefore) {
  Stream stream = MadeStream(3.0);
  DelayVelocity(stream, {MadeStamp(0.0)}, 0.25);
  EXPECT_NEAR(stream.scans[1].scan.ego_velocity->linear_mps.x(), 10.0, 1e-9);
  EXPECT_NEAR(stream.scans[20].scan.ego_velocity->linear_mps.x(), 10.175, 1e-9);
  EXPECT_NEAR(stream.scans[20].scan.ego_velocity->angular_radps.z(), 0.0175, 1e-9);
}

TEST(VelocityFaultsTest, SpinAndReportNowAndThen) {
  Stream stream = MadeStream(3.0);
  BiasSpeed(stream, {MadeStamp(0.0)}, 5.0);
  EXPECT_NEAR(stream.scans[10].scan.ego_velocity->linear_mps.x(), 15.1, 1e-9);
  ThinVelocity(stream, {MadeStamp(0.0)}, 3);
  for (std::size_t i = 0; i < stream.scans.size(); ++i) {
    EXPECT_EQ(stream.scans[i].scan.ego_velocity.has_value(), i % 3 == 0);
  }
}

TEST(VelocityFaultsTest, DropTheVelocityAndStateItsDeviation) {
  Stream stream = MadeStream(3.0);
  DropVelocity(stream, kSecond);
  EXPECT_FALSE(stream.scans[10].scan.ego_velocity.has_value());
  ASSERT_TRUE(stream.scans[20].scan.ego_velocity.has_value());
  StateVelocitySigma(stream, {MadeStamp(0.0)}, 1e-6);
  EXPECT_FALSE(stream.scans[10].scan.ego_velocity.has_value());
  const auto& covariance = stream.scans[20].scan.ego_velocity->covariance;
  ASSERT_TRUE(covariance.has_value());
  EXPECT_NEAR((*covariance)(5, 5), 1e-12, 1e-20);
  EXPECT_EQ((*covariance)(0, 1), 0.0);
}

}  // namespace
}  // namespace dcloc::faults
