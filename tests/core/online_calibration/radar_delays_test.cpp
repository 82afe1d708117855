#include "core/online_calibration/radar_delays.h"

#include <gtest/gtest.h>

#include "tests/core/online_calibration/late_radars.h"

namespace dcloc {
namespace {

RadarDelays DelaysAfter(double duration_s, const LateDrive& drive, const Rig& rig = FrontAndRear(),
                        bool is_sound = true) {
  RadarDelays delays(rig, {});
  ForEachScan(rig, drive, duration_s, [&](const Scan& scan, std::size_t index) {
    delays.OnScan(scan.stamp, index, scan, is_sound);
  });
  return delays;
}

TEST(RadarDelaysTest, EachRadarHasItsOwn) {
  const RadarDelays delays = DelaysAfter(120.0, {.late_s = {0.115, 0.05}});
  ASSERT_TRUE(delays.Late(0) && delays.Late(1));
  EXPECT_NEAR(delays.Late(0)->value, 0.115, 0.005);
  EXPECT_NEAR(delays.Late(1)->value, 0.05, 0.005);
  EXPECT_LT(std::sqrt(delays.Late(0)->variance), 0.006);
}

TEST(RadarDelaysTest, TheDeviationIsThatOfTheErrors) {
  for (const double late_s : {0.0, 0.02, 0.1, 0.13, 0.25}) {
    const RadarDelays delays = DelaysAfter(60.0, {.late_s = {late_s, late_s}});
    ASSERT_TRUE(delays.Late(0)) << late_s;
    EXPECT_LT(std::abs(delays.Late(0)->value - late_s), 3.0 * std::sqrt(delays.Late(0)->variance));
  }
}

TEST(RadarDelaysTest, AVelocityThatIsLateIsNoDelayOfRadars) {
  const RadarDelays delays = DelaysAfter(120.0, {.late_s = {0.0, 0.0}, .reported_late_s = 0.15});
  ASSERT_TRUE(delays.AgainstReported(0) && delays.Late(1));
  EXPECT_NEAR(delays.AgainstReported(0)->value, -0.15, 0.005);
  EXPECT_NEAR(delays.Late(0)->value, 0.0, 0.006);
  EXPECT_NEAR(delays.Late(1)->value, 0.0, 0.006);
}

TEST(RadarDelaysTest, BothMayBeLate) {
  const RadarDelays delays = DelaysAfter(120.0, {.late_s = {0.0, 0.1}, .reported_late_s = 0.2});
  ASSERT_TRUE(delays.Late(0) && delays.Late(1));
  EXPECT_NEAR(delays.Late(0)->value, 0.0, 0.006);
  EXPECT_NEAR(delays.Late(1)->value, 0.1, 0.008);
}

TEST(RadarDelaysTest, NeitherScaleNorDescribedOffsetIsADelay) {
  Rig rig = FrontAndRear();
  for (RadarModel& radar : rig.radars) radar.time_offset_s = -0.1;
  const RadarDelays delays = DelaysAfter(120.0, {.late_s = {0.1, 0.16}, .scale = 1.04}, rig);
  ASSERT_TRUE(delays.Late(0) && delays.Late(1));
  EXPECT_NEAR(delays.Late(0)->value, 0.0, 0.006);
  EXPECT_NEAR(delays.Late(1)->value, 0.06, 0.006);
}

TEST(RadarDelaysTest, ASteadyDriveSaysNothingThatCounts) {
  const LateDrive steady{.late_s = {0.1, 0.1},
                         .speed_mps = [](double) { return 14.0; },
                         .yaw_rate_radps = [](double) { return 0.0; }};
  const RadarDelays delays = DelaysAfter(300.0, steady);
  for (const std::size_t index : {0U, 1U}) {
    EXPECT_TRUE(!delays.Late(index) || std::sqrt(delays.Late(index)->variance) > 0.05);
  }
}

TEST(RadarDelaysTest, DopplerThatDiffersFromTheWheelsSaysNothing) {
  EXPECT_FALSE(DelaysAfter(60.0, {.late_s = {0.1, 0.1}, .range_rate_error_mps = 0.6}).Late(0));
  EXPECT_FALSE(DelaysAfter(60.0, {.late_s = {0.1, 0.1}, .range_rate_scale = 1.5}).Late(0));
  EXPECT_FALSE(DelaysAfter(60.0, {.late_s = {0.1, 0.1}}, FrontAndRear(), false).Late(0));
}

TEST(RadarDelaysTest, ADelayBeyondTheComparedOnesIsNotTold) {
  EXPECT_FALSE(DelaysAfter(60.0, {.late_s = {0.6, 0.6}}).Late(0));
}

TEST(RadarDelaysTest, AnotherDriveGoesOnWithWhatIsKnown) {
  const Rig rig = FrontAndRear();
  RadarDelays delays(rig, {});
  for (int drive = 0; drive < 4; ++drive) {
    delays.OnDiscontinuity();
    ForEachScan(rig, {.late_s = {0.1, 0.1}}, 30.0, [&](const Scan& scan, std::size_t index) {
      delays.OnScan(scan.stamp, index, scan, true);
    });
  }
  delays.Update();
  ASSERT_TRUE(delays.Late(0));
  EXPECT_NEAR(delays.Late(0)->value, 0.1, 0.006);
}

}  // namespace
}  // namespace dcloc
