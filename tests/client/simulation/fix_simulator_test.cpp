#include "client/simulation/fix_simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/client/fixtures/field_cases.h"

namespace dcloc {
namespace {

TEST(FixOptionsTest, EachFieldIsValidated) {
  // A field that is added does not compile here until it has a row below.
  [[maybe_unused]] const auto& [rate_hz, sigma_m, heading_sigma_deg, jumps_per_min, jump_m, jump_s,
                                outages_per_min, outage_s] = FixOptions{};
  const auto expect = [](const char* name, double FixOptions::*field, const Allowed& allowed) {
    ExpectEachFieldIsValidated<FixOptions>(
        {}, {{name, [field](auto& o, double v) { o.*field = v; }, allowed}});
  };
  expect("fixes rate_hz", &FixOptions::rate_hz, {.zero = "no fixes"});
  expect("fixes sigma_m", &FixOptions::sigma_m, {});
  expect("fixes heading_sigma_deg", &FixOptions::heading_sigma_deg, {.zero = "no heading"});
  expect("fixes jumps_per_min", &FixOptions::jumps_per_min, {.zero = "no jumps"});
  expect("fixes jump_m", &FixOptions::jump_m, {.zero = "no jumps"});
  expect("fixes jump_s", &FixOptions::jump_s, {});
  expect("fixes outages_per_min", &FixOptions::outages_per_min, {.zero = "no outages"});
  expect("fixes outage_s", &FixOptions::outage_s, {});
}

class FixSimulatorTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    SimulationOptions options;
    options.length_m = 1000.0;
    pass_ = *SimulatePassWithTruth(MakeWorld(options), options, Passes(options)[1]);
    for (const VehicleSignal& signal : pass_.signals) truth_[signal.stamp] = signal.T_map_vehicle;
  }
  static void TearDownTestSuite() { pass_ = {}; }

  /// In the map frame.
  static std::vector<StampedFix> Fixes(const FixOptions& options, std::uint64_t seed = 1) {
    return SimulateFixes(pass_, 1, options, seed, std::nullopt);
  }

  static double Error_m(const StampedFix& fix) {
    const Eigen::Vector3d error =
        std::get<MapFix>(fix.position).p_map - truth_.at(fix.stamp).translation_m;
    return std::hypot(error.x(), error.y());
  }

  static double Duration_s() {
    const auto& scans = pass_.drive.scans;
    return std::chrono::duration<double>(scans.back().scan.stamp - scans.front().scan.stamp)
        .count();
  }

  static inline SimulatedPass pass_;
  static inline std::map<Stamp, Pose3> truth_;
};

TEST_F(FixSimulatorTest, ComeAtTheirRateWithTheNoiseThatTheyClaim) {
  const auto fixes = Fixes({.rate_hz = 10.0, .sigma_m = 2.0});
  EXPECT_NEAR(static_cast<double>(fixes.size()), 10.0 * Duration_s(), 3.0);
  double sum_m2 = 0.0;
  for (const StampedFix& fix : fixes) {
    EXPECT_EQ(std::get<MapFix>(fix.position).horizontal_sigma_m, 2.0);
    EXPECT_FALSE(std::get<MapFix>(fix.position).yaw_deg.has_value());
    sum_m2 += Error_m(fix) * Error_m(fix);
  }
  EXPECT_NEAR(std::sqrt(sum_m2 / static_cast<double>(fixes.size())), std::sqrt(2.0) * 2.0, 0.3);
  EXPECT_TRUE(Fixes({.rate_hz = 0.0}).empty());
}

TEST_F(FixSimulatorTest, JumpsAreFarBeyondTheSigmaAndLast) {
  const FixOptions options{
      .rate_hz = 10.0, .sigma_m = 0.1, .jumps_per_min = 4.0, .jump_m = 20.0, .jump_s = 3.0};
  const auto fixes = Fixes(options);
  const auto jumped = static_cast<double>(
      std::ranges::count_if(fixes, [](const StampedFix& fix) { return Error_m(fix) > 5.0; }));
  EXPECT_GT(jumped, 25.0) << "at least one of 3 s";
  EXPECT_LT(jumped, 0.5 * static_cast<double>(fixes.size()));
  EXPECT_EQ(
      std::ranges::count_if(
          fixes, [](const StampedFix& fix) { return Error_m(fix) > 1.0 && Error_m(fix) < 9.0; }),
      0);
}

TEST_F(FixSimulatorTest, OutagesLeaveFixesOutAndChangeNoOther) {
  const auto all = Fixes({.rate_hz = 10.0});
  const auto left = Fixes({.rate_hz = 10.0, .outages_per_min = 3.0, .outage_s = 5.0});
  EXPECT_LE(left.size() + 45, all.size());
  for (const StampedFix& fix : left) {
    const auto same = std::ranges::find(all, fix.stamp, &StampedFix::stamp);
    ASSERT_NE(same, all.end());
    EXPECT_EQ(std::get<MapFix>(same->position).p_map, std::get<MapFix>(fix.position).p_map);
  }
}

TEST_F(FixSimulatorTest, TheSeedDecides) {
  const FixOptions options{.rate_hz = 1.0};
  const auto place = [](const StampedFix& fix) { return std::get<MapFix>(fix.position).p_map; };
  EXPECT_EQ(place(Fixes(options, 1)[0]), place(Fixes(options, 1)[0]));
  EXPECT_NE(place(Fixes(options, 1)[0]), place(Fixes(options, 2)[0]));
}

TEST_F(FixSimulatorTest, WithAnAnchorTheyAreOnTheEarth) {
  const GeodeticAnchor anchor{
      .origin = {.latitude_deg = 48.0, .longitude_deg = 10.0, .height_m = 400.0},
      .x_axis_east_rad = 0.5};
  const auto fixes = SimulateFixes(
      pass_, 1, {.rate_hz = 1.0, .sigma_m = 0.01, .heading_sigma_deg = 1.0}, 1, anchor);
  ASSERT_FALSE(fixes.empty());
  const GnssFix& fix = std::get<GnssFix>(fixes[0].position);
  const Eigen::Vector3d p_map = MapFromGeodetic(anchor, fix.position);
  EXPECT_LT((p_map - truth_.at(fixes[0].stamp).translation_m).norm(), 0.2);
  EXPECT_TRUE(fix.heading_deg.has_value());
}

}  // namespace
}  // namespace dcloc
