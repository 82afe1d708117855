#include "client/evaluation/faults/time_faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

using std::chrono::milliseconds;

const Window kAlways = {MadeStamp(0.0)};

std::vector<std::string> RadarsOf(const Stream& stream, std::size_t count) {
  std::vector<std::string> radars;
  for (std::size_t i = 0; i < count; ++i) radars.push_back(stream.scans[i].scan.radar_id);
  return radars;
}

TEST(TimeFaultsTest, ShiftWhatStampsSayAndNothingElse) {
  Stream stream = MadeStream(2.0, 2);
  ShiftStamps(stream, {MadeStamp(1.0)}, milliseconds(-200), "b");
  for (const StreamScan& entry : stream.scans) {
    const bool is_shifted = entry.scan.radar_id == "b" && entry.measured >= MadeStamp(1.0);
    EXPECT_EQ(entry.scan.stamp, entry.measured - milliseconds(is_shifted ? 200 : 0));
    EXPECT_EQ(entry.arrived, entry.measured);
  }
  ShiftStamps(stream, {MadeStamp(0.0), MadeStamp(0.5)}, std::chrono::minutes(10));
  EXPECT_EQ(stream.scans[0].scan.stamp, MadeStamp(600.0));
  EXPECT_EQ(stream.scans[1].scan.stamp, MadeStamp(600.02));
  EXPECT_EQ(stream.scans[10].scan.stamp, MadeStamp(0.5));
}

TEST(TimeFaultsTest, LateScansComeBehindOthers) {
  Stream stream = MadeStream(1.0, 2);
  DelayArrival(stream, kAlways, "a", milliseconds(60));
  EXPECT_EQ(RadarsOf(stream, 4), (std::vector<std::string>{"b", "a", "b", "a"}));
  EXPECT_EQ(stream.scans[1].scan.stamp, MadeStamp(0.0));
  EXPECT_EQ(stream.scans[1].measured, MadeStamp(0.0));
  EXPECT_EQ(stream.scans[1].arrived, MadeStamp(0.06));
}

TEST(TimeFaultsTest, JitterMixesTheOrderAndIsDrawnFromTheSeed) {
  Stream stream = MadeStream(5.0), again = stream, other = stream;
  JitterArrival(stream, kAlways, milliseconds(250), 1);
  JitterArrival(again, kAlways, milliseconds(250), 1);
  JitterArrival(other, kAlways, milliseconds(250), 2);
  EXPECT_TRUE(std::ranges::is_sorted(stream.scans, {}, &StreamScan::arrived));
  EXPECT_FALSE(std::ranges::is_sorted(stream.scans, {}, &StreamScan::measured));
  bool differs = false;
  for (std::size_t i = 0; i < stream.scans.size(); ++i) {
    const StreamScan& entry = stream.scans[i];
    EXPECT_LE(entry.arrived - entry.measured, milliseconds(250));
    EXPECT_EQ(entry.scan.stamp, entry.measured);
    EXPECT_EQ(entry.arrived, again.scans[i].arrived);
    differs = differs || entry.arrived != other.scans[i].arrived;
  }
  EXPECT_TRUE(differs);
}

TEST(TimeFaultsTest, EachTenthScanComesTwice) {
  Stream stream = MadeStream(2.5);
  DuplicateScans(stream, {MadeStamp(0.5)}, 10);
  ASSERT_EQ(stream.scans.size(), 27U);
  EXPECT_EQ(stream.scans[5].scan.stamp, stream.scans[6].scan.stamp);
  EXPECT_EQ(stream.scans[16].scan.stamp, stream.scans[17].scan.stamp);
  EXPECT_EQ(stream.scans[17].scan.size(), 10U);
}

TEST(TimeFaultsTest, StampsAreRounded) {
  Stream stream = MadeStream(1.0, 3);  // scans at 0, 20 and 40 ms
  RoundStamps(stream, kAlways, milliseconds(50));
  EXPECT_EQ(stream.scans[3].scan.stamp, MadeStamp(0.1));
  EXPECT_EQ(stream.scans[4].scan.stamp, MadeStamp(0.1));
  EXPECT_EQ(stream.scans[5].scan.stamp, MadeStamp(0.15));
  EXPECT_EQ(stream.scans[5].measured, MadeStamp(0.14));
}

TEST(TimeFaultsTest, ACycleHasOneStamp) {
  Stream stream = MadeStream(1.0, 3);
  AlignStamps(stream, {MadeStamp(0.2)});
  EXPECT_EQ(stream.scans[5].scan.stamp, MadeStamp(0.14));
  for (std::size_t i = 6; i < 9; ++i) EXPECT_EQ(stream.scans[i].scan.stamp, MadeStamp(0.2));
  EXPECT_EQ(stream.scans[8].measured, MadeStamp(0.24));
}

TEST(TimeFaultsTest, EachRadarIsThinned) {
  Stream stream = MadeStream(10.0, 2);
  ThinScans(stream, kAlways, 2.0);
  EXPECT_EQ(stream.scans.size(), 40U);
  EXPECT_EQ(RadarsOf(stream, 4), (std::vector<std::string>{"a", "b", "a", "b"}));
  EXPECT_EQ(stream.scans[2].scan.stamp, MadeStamp(0.5));
}

// A clock that is set stays so, though the fault is of a moment.
TEST(TimeFaultsTest, AClockThatIsSetStaysSo) {
  const std::vector<Fault> faults = TimeFaults();
  const auto back = std::ranges::find(faults, "time-back-5s", &Fault::id);
  ASSERT_NE(back, faults.end());
  Stream stream = MadeStream(30.0);
  const Window window = WindowOf(*back, stream);
  EXPECT_EQ(window.begin, MadeStamp(20.0));
  EXPECT_EQ(window.end, window.begin);
  back->apply(stream, window, 1);
  EXPECT_EQ(stream.scans[199].scan.stamp, MadeStamp(19.9));
  EXPECT_EQ(stream.scans[200].scan.stamp, MadeStamp(15.0));
  EXPECT_EQ(stream.scans.back().scan.stamp, MadeStamp(24.9));
}

}  // namespace
}  // namespace dcloc::faults
