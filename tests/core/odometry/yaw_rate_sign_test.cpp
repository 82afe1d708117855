#include "core/odometry/yaw_rate_sign.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

namespace dcloc {
namespace {

using std::chrono::milliseconds;

/// A vehicle at 12 m/s whose Doppler turns with the speed by what a mount is off.
class YawRateSignTest : public ::testing::Test {
 protected:
  // Goes straight on and then through curves to both sides; returns how often the sign changed.
  int Drive(double duration_s) {
    int changes = 0;
    for (const double end_s = now_s_ + duration_s; now_s_ < end_s; now_s_ += 0.075) {
      if (GiveMoment()) ++changes;
    }
    return changes;
  }

  bool GiveMoment() {
    const double yaw_rate_radps = YawRateAt(now_s_);
    const double sent_radps = sign * yaw_rate_radps + noise(0.002);
    const double reported_radps = learned_.is_reversed() ? -sent_radps : sent_radps;
    const double doppler_radps = yaw_rate_radps + mount_per_m * kSpeed_mps + noise(0.02);
    stamp_ += milliseconds(75);
    return learned_.OnYawRates(stamp_, kSpeed_mps, reported_radps, doppler_radps);
  }

  // Curves of two seconds, every eight seconds.
  static double YawRateAt(double time_s) {
    const double in_round_s = std::fmod(time_s, 8.0);
    const double side = std::fmod(time_s, 16.0) < 8.0 ? 1.0 : -1.0;
    return in_round_s < 6.0 ? 0.0 : side * 0.4 * std::sin(0.5 * M_PI * (in_round_s - 6.0));
  }

  double noise(double sigma) { return std::normal_distribution<double>(0.0, sigma)(random_); }

  static constexpr double kSpeed_mps = 12.0;
  double sign = 1.0;
  double mount_per_m = 0.0;  // Doppler's yaw rate by the speed
  YawRateSign learned_;
  double now_s_ = 0.0;

 private:
  std::mt19937_64 random_{7};
  Stamp stamp_{std::chrono::seconds(1000)};
};

TEST_F(YawRateSignTest, ARightSignStays) {
  EXPECT_EQ(Drive(120.0), 0);
  EXPECT_FALSE(learned_.is_reversed());
}

TEST_F(YawRateSignTest, AWrongSignIsFoundWhereACurveBegins) {
  sign = -1.0;
  EXPECT_EQ(Drive(6.0), 0) << "straight ahead both are alike";
  EXPECT_EQ(Drive(0.6), 1);
  EXPECT_TRUE(learned_.is_reversed());
  EXPECT_LT(std::abs(learned_.turn_rad()), 0.15);
  EXPECT_EQ(Drive(60.0), 0) << "it stays found";
}

TEST_F(YawRateSignTest, ASignThatIsMendedIsFoundToo) {
  sign = -1.0;
  Drive(20.0);
  sign = 1.0;
  EXPECT_EQ(Drive(8.0), 1);
  EXPECT_FALSE(learned_.is_reversed());
}

// By ten degrees, seen by one radar 3.7 m ahead: more than any curve here turns.
TEST_F(YawRateSignTest, AMountThatIsOffIsNoSign) {
  for (const double off_rad : {-0.17, 0.17}) {
    mount_per_m = off_rad / 3.7;
    EXPECT_EQ(Drive(60.0), 0) << off_rad;
  }
}

TEST_F(YawRateSignTest, AMountThatIsKnockedIsNoSignWheneverItHappens) {
  for (double at_s = 5.0; at_s < 9.0; at_s += 0.15) {
    for (const double off_rad : {-0.17, -0.08, 0.08, 0.17}) {
      learned_ = {};
      now_s_ = 0.0;
      mount_per_m = 0.0;
      Drive(at_s);
      mount_per_m = off_rad / 3.7;
      Drive(16.0);
      EXPECT_FALSE(learned_.is_reversed()) << at_s << " s, " << off_rad;
    }
  }
}

}  // namespace
}  // namespace dcloc
