#include "core/localizer/radar_monitor.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

class RadarMonitorTest : public ::testing::Test {
 protected:
  // All radars scan ten times a second, but for one that is silent.
  void Drive(int scans, std::size_t silent = 99) {
    for (int i = 0; i < scans; ++i) {
      stamp_ += std::chrono::milliseconds(100);
      for (std::size_t radar = 0; radar < 4; ++radar) {
        if (radar != silent) monitor_.OnScan(stamp_, radar, 100, 60);
      }
    }
  }

  RadarMonitor monitor_{4, {}};
  Stamp stamp_{std::chrono::seconds(1)};
};

TEST_F(RadarMonitorTest, NothingIsWrongWithSoundRadars) {
  Drive(30);
  for (std::size_t radar = 0; radar < 4; ++radar) {
    EXPECT_EQ(monitor_.FaultOf(radar, stamp_), SourceFault::kNone);
  }
}

TEST_F(RadarMonitorTest, SilenceIsReportedAndEnds) {
  EXPECT_EQ(monitor_.FaultOf(2, stamp_), SourceFault::kSilent) << "never heard of";
  Drive(30);
  Drive(4, 2);
  EXPECT_EQ(monitor_.FaultOf(2, stamp_), SourceFault::kNone);
  Drive(4, 2);
  EXPECT_EQ(monitor_.FaultOf(2, stamp_), SourceFault::kSilent);
  Drive(1);
  EXPECT_EQ(monitor_.FaultOf(2, stamp_), SourceFault::kNone);
}

TEST_F(RadarMonitorTest, ASlowRadarIsNotSilent) {
  for (int i = 0; i < 10; ++i) {
    stamp_ += std::chrono::seconds(1);
    monitor_.OnScan(stamp_, 0, 100, 60);
  }
  EXPECT_EQ(monitor_.FaultOf(0, stamp_ + std::chrono::milliseconds(1500)), SourceFault::kNone);
}

TEST_F(RadarMonitorTest, RangeRatesThatNothingExplainsAreReported) {
  Drive(30);
  for (int i = 0; i < 30; ++i) monitor_.OnScan(stamp_, 1, 100, 2);
  EXPECT_EQ(monitor_.FaultOf(1, stamp_), SourceFault::kDoppler);
}

TEST_F(RadarMonitorTest, AnotherClockIsReported) {
  Drive(30);
  monitor_.ReportClockOffset(1, true);
  EXPECT_EQ(monitor_.FaultOf(1, stamp_), SourceFault::kClock);
  monitor_.ReportClockOffset(1, false);
  EXPECT_EQ(monitor_.FaultOf(1, stamp_), SourceFault::kNone);
}

TEST_F(RadarMonitorTest, ARadarWhoseScansAllComeLateIsNotSilent) {
  Drive(30, 1);
  for (int i = 0; i < 30; ++i) {
    Drive(1, 1);
    monitor_.OnScan(stamp_ - std::chrono::milliseconds(250), 1, 100, 60);
  }
  EXPECT_EQ(monitor_.FaultOf(1, stamp_), SourceFault::kNone);
}

TEST_F(RadarMonitorTest, TheOneThatDoesNotFitTheMapIsSetAside) {
  Drive(30);
  for (int i = 0; i < 30; ++i) {
    for (std::size_t radar = 0; radar < 4; ++radar) monitor_.OnFit(radar, radar == 3 ? 0.1 : 0.5);
  }
  EXPECT_FALSE(monitor_.FitsTheMap(3));
  EXPECT_EQ(monitor_.FaultOf(3, stamp_), SourceFault::kMap);
  EXPECT_TRUE(monitor_.FitsTheMap(0));
  for (int i = 0; i < 30; ++i) monitor_.OnFit(3, 0.5);
  EXPECT_TRUE(monitor_.FitsTheMap(3));
}

TEST_F(RadarMonitorTest, WhereNoneFitsNobodyIsToBlame) {
  for (int i = 0; i < 30; ++i) {
    for (std::size_t radar = 0; radar < 4; ++radar) monitor_.OnFit(radar, radar == 3 ? 0.0 : 0.1);
  }
  EXPECT_TRUE(monitor_.FitsTheMap(3));
  monitor_.OnFit(0, 1.0);
  monitor_.ResetFits();
  EXPECT_TRUE(monitor_.FitsTheMap(3));
}

TEST_F(RadarMonitorTest, TwoRadarsCannotJudgeOneAnother) {
  RadarMonitor two(2, {});
  for (int i = 0; i < 30; ++i) {
    two.OnFit(0, 0.6);
    two.OnFit(1, 0.05);
  }
  EXPECT_TRUE(two.FitsTheMap(1));
}

}  // namespace
}  // namespace dcloc
