#include "core/localizer/health.h"

#include <gtest/gtest.h>

#include <string>

namespace dcloc {
namespace {

class HealthTest : public ::testing::Test {
 protected:
  HealthTest() {
    for (std::size_t i = 0; i < kRadars; ++i) {
      monitor_.OnScan(kNow, i, 100, 60);
      monitor_.OnFit(i, 0.5);
    }
  }

  static Rig FourRadars() {
    Rig rig;
    for (std::size_t i = 0; i < kRadars; ++i) {
      rig.radars.emplace_back().id = std::to_string(i);
    }
    return rig;
  }
  SourceHealth Reported(std::size_t index, Stamp stamp) const {
    return ReportHealth(stamp, EgoMotion(), rig_, signs_, scales_, offsets_, monitor_)
        .radars[index];
  }

  static constexpr std::size_t kRadars = 4;
  static constexpr Stamp kNow{std::chrono::seconds(100)};
  LearnedRig rig_{FourRadars(), {}};
  AzimuthSigns signs_{kRadars, {}};
  RangeRateErrors scales_{kRadars, {}};
  RangeRateOffsets offsets_{kRadars, {}};
  RadarMonitor monitor_{kRadars, {}};
};

TEST_F(HealthTest, AMirroredRadarIsUsedAndReported) {
  constexpr std::size_t kPoints = 50;
  while (!signs_.OnFits(2, kPoints, 0.1, 0.5)) {
  }
  EXPECT_EQ(Reported(2, kNow), (SourceHealth{.is_used = true, .fault = SourceFault::kMount}));
  EXPECT_EQ(Reported(1, kNow).fault, SourceFault::kNone);
}

TEST_F(HealthTest, ASoundRadarIsTrustedAndUsed) {
  EXPECT_TRUE(IsTrusted(1, kNow, rig_, monitor_));
  EXPECT_EQ(Reported(1, kNow), (SourceHealth{.is_used = true, .fault = SourceFault::kNone}));
}

TEST_F(HealthTest, ARadarThatSeesAnotherMapIsNeitherTrustedNorUsed) {
  for (int i = 0; i < 100; ++i) monitor_.OnFit(1, 0.01);
  EXPECT_FALSE(IsTrusted(1, kNow, rig_, monitor_));
  EXPECT_EQ(Reported(1, kNow), (SourceHealth{.is_used = false, .fault = SourceFault::kMap}));
}

TEST_F(HealthTest, ASilentRadarIsTrustedButNotUsed) {
  const Stamp later = kNow + std::chrono::seconds(10);
  EXPECT_TRUE(IsTrusted(1, later, rig_, monitor_));
  EXPECT_EQ(Reported(1, later), (SourceHealth{.is_used = false, .fault = SourceFault::kSilent}));
}

TEST_F(HealthTest, ARadarOfWhichNothingStandsStillIsTrustedButNotUsed) {
  for (int i = 0; i < 100; ++i) monitor_.OnScan(kNow, 1, 100, 0);
  EXPECT_TRUE(IsTrusted(1, kNow, rig_, monitor_));
  EXPECT_EQ(Reported(1, kNow), (SourceHealth{.is_used = false, .fault = SourceFault::kDoppler}));
}

TEST_F(HealthTest, ARadarOfAnotherClockIsUsed) {
  monitor_.ReportClockOffset(1, true);
  EXPECT_EQ(Reported(1, kNow), (SourceHealth{.is_used = true, .fault = SourceFault::kClock}));
}

}  // namespace
}  // namespace dcloc
