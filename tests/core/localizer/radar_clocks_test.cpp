#include "core/localizer/radar_clocks.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace dcloc {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// Radars that scan ten times a second, one a little after the other. Each has a clock that is off,
/// and a time that its scans are on their way.
class RadarClocksTest : public ::testing::Test {
 protected:
  void SetUp() override { Make(4); }

  void Make(std::size_t radar_count) {
    clocks_.emplace(radar_count, RadarClocksOptions{});
    is_off_.assign(radar_count, nanoseconds(0));
    is_silent_.assign(radar_count, false);
  }

  /// The scans that were not given a time.
  int Drive(int cycles) {
    int unplaced = 0;
    for (int i = 0; i < cycles; ++i, now_ += milliseconds(100)) {
      for (std::size_t radar = 0; radar < is_off_.size(); ++radar) {
        if (is_silent_[radar]) continue;
        const Stamp taken = now_ + nanoseconds(milliseconds(100)) * radar / is_off_.size();
        const std::optional<Stamp> aligned = clocks_->Align(radar, taken + is_off_[radar]);
        if (!aligned) {
          ++unplaced;
        } else {
          last_error_ = *aligned - taken;
          worst_error_ = std::max(worst_error_, nanoseconds(std::chrono::abs(last_error_)));
        }
      }
    }
    return unplaced;
  }

  std::optional<RadarClocks> clocks_;
  std::vector<nanoseconds> is_off_;
  std::vector<bool> is_silent_;
  Stamp now_{seconds(1000)};
  nanoseconds last_error_{0};
  nanoseconds worst_error_{0};
};

TEST_F(RadarClocksTest, StampsOfOneClockStayAsTheyAre) {
  EXPECT_EQ(Drive(50), 0);
  EXPECT_EQ(worst_error_.count(), 0);
}

TEST_F(RadarClocksTest, AnOffsetIsReportedWithItsVariance) {
  is_off_[1] = seconds(20);
  Drive(50);
  EXPECT_FALSE(clocks_->OffsetEstimate(0));
  const std::optional<ScalarEstimate> offset_s = clocks_->OffsetEstimate(1);
  ASSERT_TRUE(offset_s);
  EXPECT_NEAR(offset_s->value, 20.0, 0.1);
  EXPECT_DOUBLE_EQ(offset_s->variance, 0.05 * 0.05);
}

TEST_F(RadarClocksTest, ScansThatComeLateAreOfTheSameClock) {
  is_off_[2] = -milliseconds(250);
  EXPECT_EQ(Drive(50), 0);
  EXPECT_FALSE(clocks_->IsOff(2));
}

TEST_F(RadarClocksTest, AnotherClockIsBroughtToThatOfTheOthers) {
  for (const nanoseconds off :
       {nanoseconds(milliseconds(400)), nanoseconds(milliseconds(-400)), nanoseconds(seconds(5)),
        nanoseconds(seconds(-5)), nanoseconds(std::chrono::hours(1000))}) {
    for (const std::size_t radar_count : {3U, 5U}) {
      Make(radar_count);
      is_off_[1] = off;
      EXPECT_LE(Drive(6), 6);
      worst_error_ = {};
      EXPECT_EQ(Drive(50), 0);
      EXPECT_TRUE(clocks_->IsOff(1));
      EXPECT_FALSE(clocks_->IsOff(0));
      EXPECT_LE(worst_error_, milliseconds(50)) << off.count();
    }
  }
}

TEST_F(RadarClocksTest, AClockThatIsSetIsFollowed) {
  for (const std::size_t radar_count : {2U, 4U}) {
    for (const nanoseconds off : {nanoseconds(seconds(7)), nanoseconds(seconds(-7))}) {
      Make(radar_count);
      Drive(20);
      is_off_[0] = off;
      Drive(6);
      worst_error_ = {};
      EXPECT_EQ(Drive(20), 0);
      EXPECT_TRUE(clocks_->IsOff(0));
      EXPECT_LE(worst_error_, milliseconds(60)) << radar_count;
      is_off_[0] = {};
      Drive(6);
      worst_error_ = {};
      Drive(20);
      EXPECT_LE(worst_error_, milliseconds(60)) << radar_count;
    }
  }
}

TEST_F(RadarClocksTest, AScanThatLeadsAllOthersIsNotPlaced) {
  Drive(20);
  is_off_[3] = std::chrono::minutes(10);
  EXPECT_EQ(Drive(1), 1);
  EXPECT_EQ(worst_error_.count(), 0) << "of the others";
}

TEST_F(RadarClocksTest, TheClockOfAllMayBeSet) {
  Drive(20);
  for (const nanoseconds off : {nanoseconds(std::chrono::minutes(10)), nanoseconds(seconds(-5))}) {
    is_off_.assign(4, off);
    EXPECT_LE(Drive(20), 1);
    EXPECT_EQ(last_error_, off);
    for (std::size_t radar = 0; radar < 4; ++radar) EXPECT_FALSE(clocks_->IsOff(radar));
  }
}

TEST_F(RadarClocksTest, AfterASilenceTimeGoesOn) {
  Drive(20);
  now_ += seconds(8);
  EXPECT_LE(Drive(20), 1);
  EXPECT_EQ(worst_error_.count(), 0);
  is_silent_ = {false, true, true, true};
  EXPECT_EQ(Drive(50), 0);
  is_silent_ = {false, false, false, false};
  EXPECT_EQ(Drive(50), 0);
  EXPECT_EQ(worst_error_.count(), 0);
}

TEST_F(RadarClocksTest, ASingleRadarHasNoOthers) {
  Make(1);
  Drive(10);
  is_off_[0] = seconds(100);
  EXPECT_EQ(Drive(10), 0);
  EXPECT_FALSE(clocks_->IsOff(0));
}

TEST_F(RadarClocksTest, AheadOfMostOrBehindThemARadarIsSuspected) {
  for (const nanoseconds off : {milliseconds(60), milliseconds(150), milliseconds(-150)}) {
    Make(5);
    is_off_[1] = off;
    EXPECT_EQ(Drive(10), 0);
    EXPECT_FALSE(clocks_->IsOff(1));
    const std::optional<RadarClocks::Suspect> suspect = clocks_->Suspected();
    ASSERT_TRUE(suspect) << off.count();
    EXPECT_EQ(suspect->index, 1U);
    EXPECT_LE(std::chrono::abs(suspect->ahead - off), milliseconds(25)) << off.count();
  }
}

TEST_F(RadarClocksTest, NobodyIsSuspectedInOrder) {
  Drive(10);
  EXPECT_FALSE(clocks_->Suspected());
  Make(2);
  is_off_[1] = milliseconds(80);
  Drive(10);
  EXPECT_FALSE(clocks_->Suspected()) << "of two nobody knows which one it is";
}

TEST_F(RadarClocksTest, FitsTellWhetherASuspectIsOff) {
  struct Case {
    const char* what;
    double lead_of_suspect, lead_of_others;
    bool is_off;
  };
  for (const Case& told : {Case{"the pose follows the others", 0.1, -0.1, true},
                           {"the pose follows the suspect", -0.1, 0.1, true},
                           {"scans come late", -0.1, -0.1, false},
                           {"the pose is behind", 0.1, 0.1, false},
                           {"the vehicle stands", 0.0, 0.0, false}}) {
    Make(4);
    is_off_[1] = milliseconds(80);
    Drive(10);
    const std::optional<RadarClocks::Suspect> suspect = clocks_->Suspected();
    ASSERT_TRUE(suspect);
    bool is_off = false;
    for (int cycle = 0; cycle < 50 && !is_off && clocks_->Suspected(); ++cycle) {
      for (std::size_t i = 0; i < 4 && !is_off; ++i) {
        const double lead = i == suspect->index ? told.lead_of_suspect : told.lead_of_others;
        is_off = clocks_->OnFits(*suspect, i, 0.5, 0.5 + lead);
      }
    }
    EXPECT_EQ(is_off, told.is_off) << told.what;
    const bool is_right = told.lead_of_suspect < 0.0 && !told.is_off;
    EXPECT_EQ(clocks_->Suspected().has_value(), !is_right) << told.what;
  }
}

}  // namespace
}  // namespace dcloc
