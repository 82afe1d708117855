#include "core/localizability/expected_scans.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/localizability/localizability.h"
#include "core/radar/static_points.h"
#include "tests/core/localizability/row_map.h"
#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

RadarModel Radar() { return LocalizabilityOptions::DefaultVehicle().rig.radars.front(); }

TEST(ExpectedScansTest, OptionsAreChecked) { ExpectEachFieldIsBounded<ExpectedScanOptions>(); }

TEST(ExpectedScansTest, TargetsLieOnLandmarksAndMoveAsTheVehicleDoes) {
  const auto map = RowMap(10, ScatteredPosts(0.0, 90.0));
  ExpectedScans scans(map, {.unmapped_share = 0.0}, {}, 1);
  EgoVelocity velocity;
  velocity.linear_mps.x() = 12.0;
  const Pose3 T_map_vehicle = Embed({{10.0, 0.0}, 0.0});
  std::size_t count = 0;
  for (int i = 0; i < 10; ++i) {
    const Scan scan = scans.At(Radar(), T_map_vehicle, velocity, Stamp(std::chrono::hours(24)));
    ASSERT_TRUE(Validate(scan).ok());
    const std::vector<RadarPoint> points = StaticPoints(scan, Radar(), velocity, {});
    EXPECT_GT(static_cast<double>(points.size()), 0.9 * static_cast<double>(scan.size()));
    count += points.size();
    for (const RadarPoint& point : points) {
      double nearest_m = INFINITY;
      for (const TestLandmark& post : ScatteredPosts(0.0, 90.0)) {
        const Eigen::Vector2d p_vehicle_m(post.x_m - 10.0, post.y_m);
        nearest_m = std::min(nearest_m, (point.position_m.head<2>() - p_vehicle_m).norm());
      }
      EXPECT_LT(nearest_m, 5.0);  // azimuths are off by some degrees at most
    }
  }
  EXPECT_GT(count, 100U);
}

TEST(ExpectedScansTest, NothingIsSeenBehindOrFarAway) {
  const auto map = RowMap(10, {{.x_m = 0.0, .y_m = 2.0}, {.x_m = 90.0, .y_m = 2.0}});
  ExpectedScans scans(map, {.max_hit_probability = 1.0, .max_range_m = 50.0}, {}, 1);
  EXPECT_EQ(scans.At(Radar(), Embed({{20.0, 0.0}, 0.0}), {}, Stamp(std::chrono::hours(24))).size(),
            0U);
  EXPECT_GT(scans.At(Radar(), Embed({{60.0, 0.0}, 0.0}), {}, Stamp(std::chrono::hours(24))).size(),
            0U);
}

TEST(ExpectedScansTest, TheSameSeedGivesTheSameScans) {
  const auto map = RowMap(10, ScatteredPosts(0.0, 90.0));
  const auto take = [&](std::uint64_t seed) {
    ExpectedScans scans(map, {}, {}, seed);
    return scans.At(Radar(), Embed({{10.0, 0.0}, 0.0}), {}, Stamp(std::chrono::hours(24))).range_m;
  };
  EXPECT_EQ(take(1), take(1));
  EXPECT_NE(take(1), take(2));
}

TEST(ExpectedScansTest, InATunnelReturnsComeFromAnywhereAlongTheWall) {
  const auto map = RowMap(10, {{.x_m = 50.0, .y_m = 5.0, .sigma_m = 0.01}});
  const auto spread_m = [&](std::vector<bool> is_tunnel) {
    ExpectedScans scans(map, {.max_hit_probability = 1.0, .unmapped_share = 0.0},
                        std::move(is_tunnel), 1);
    double least_m = INFINITY, most_m = 0.0;
    for (int i = 0; i < 50; ++i) {
      const Scan scan =
          scans.At(Radar(), Embed({{10.0, 0.0}, 0.0}), {}, Stamp(std::chrono::hours(24)));
      for (const float range_m : scan.range_m) {
        least_m = std::min(least_m, static_cast<double>(range_m));
        most_m = std::max(most_m, static_cast<double>(range_m));
      }
    }
    return most_m - least_m;
  };
  EXPECT_LT(spread_m({}), 1.5);
  EXPECT_GT(spread_m(std::vector<bool>(10, true)), 10.0);
}

}  // namespace
}  // namespace dcloc
