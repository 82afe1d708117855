#include "client/evaluation/faults/radar_faults.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/client/evaluation/faults/made_stream.h"

namespace dcloc::faults {
namespace {

const Window kFirstSecond = {MadeStamp(0.0), MadeStamp(1.0)};

// Whether the scans of radar "a" within the first second, and no others, differ in `column`.
void ExpectChanged(const Stream& stream, std::vector<float> Scan::*column,
                   const std::function<double(double)>& change) {
  const Stream before = MadeStream(2.0, 2);
  for (std::size_t i = 0; i < stream.scans.size(); ++i) {
    const Scan& was = before.scans[i].scan;
    const bool is_changed = was.radar_id == "a" && was.stamp < MadeStamp(1.0);
    for (std::size_t row = 0; row < was.size(); ++row) {
      const double wanted = static_cast<double>((was.*column)[row]);
      EXPECT_NEAR(static_cast<double>((stream.scans[i].scan.*column)[row]),
                  is_changed ? change(wanted) : wanted, 1e-5);
    }
  }
}

TEST(RadarFaultsTest, SilenceOneOrAll) {
  Stream stream = MadeStream(2.0, 2);
  SilenceRadar(stream, kFirstSecond, "a");
  EXPECT_EQ(stream.scans.size(), 30U);
  SilenceRadar(stream, kFirstSecond, std::nullopt);
  EXPECT_EQ(stream.scans.size(), 20U);
  EXPECT_EQ(stream.scans[0].scan.stamp, MadeStamp(1.0));
}

TEST(RadarFaultsTest, MirrorAzimuths) {
  Stream stream = MadeStream(2.0, 2);
  MirrorAzimuth(stream, kFirstSecond, "a");
  ExpectChanged(stream, &Scan::azimuth_rad, [](double was) { return -was; });
}

TEST(RadarFaultsTest, AKnockTurnsWhatIsSeenTheOtherWay) {
  Stream stream = MadeStream(2.0, 2);
  KnockRadar(stream, kFirstSecond, "a", 0.2);
  ExpectChanged(stream, &Scan::azimuth_rad, [](double was) { return was - 0.2; });
}

TEST(RadarFaultsTest, ChangeRangeRatesAndLeaveRanges) {
  Stream stream = MadeStream(2.0, 2);
  ChangeRangeRate(stream, kFirstSecond, "a", -1.3, 1.0);
  ExpectChanged(stream, &Scan::range_rate_mps, [](double was) { return 1.0 - 1.3 * was; });
  ExpectChanged(stream, &Scan::range_m, [](double was) { return was; });
}

TEST(RadarFaultsTest, AMountIsDescribedTurned) {
  Stream stream = MadeStream(2.0, 2);
  TurnMount(stream, "a", 0.2);
  EXPECT_NEAR(Yaw(stream.rig.radars[0].T_vehicle_radar.rotation), 0.2, 1e-12);
  EXPECT_NEAR(Yaw(stream.rig.radars[1].T_vehicle_radar.rotation), 0.0, 1e-12);
  ExpectChanged(stream, &Scan::azimuth_rad, [](double was) { return was; });
}

TEST(RadarFaultsTest, AbsurdSigmasAreRefused) {
  Stream stream = MadeStream(2.0, 2);
  StateSigmas(stream, kFirstSecond, 1e30F);
  const Scan& scan = stream.scans[0].scan;
  EXPECT_EQ(scan.range_sigma_m, std::vector<float>(10, 1e30F));
  EXPECT_EQ(scan.azimuth_sigma_rad.size(), 10U);
  EXPECT_EQ(scan.range_rate_sigma_mps.size(), 10U);
  EXPECT_TRUE(scan.elevation_sigma_rad.empty());
  EXPECT_FALSE(Validate(scan).ok());
  EXPECT_TRUE(stream.scans.back().scan.range_sigma_m.empty());
}

}  // namespace
}  // namespace dcloc::faults
