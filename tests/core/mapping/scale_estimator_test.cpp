#include "core/mapping/scale_estimator.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "core/map/editable_map.h"

namespace dcloc {
namespace {

constexpr double kRangeNoise_m = 0.1;
constexpr double kStreet_m = 300.0;
constexpr int kScattererCount = 200;

struct Scatterer {
  Eigen::Vector2d p_m;
  double height_m;
};

/// A street's, on either side, up to `max_height_m` over the radar.
std::vector<Scatterer> Street(double max_height_m) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> aside_m(5.0, 20.0);
  std::uniform_real_distribution<double> height_m(0.0, max_height_m);
  std::vector<Scatterer> scatterers;
  for (int i = 0; i < kScattererCount; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    scatterers.push_back({{1.5 * i, side * aside_m(random)}, height_m(random)});
  }
  return scatterers;
}

/// The map of poses that lie nearer to one another than they should, by the share `missing`.
std::shared_ptr<const RadarMap> MapOf(const std::vector<Scatterer>& scatterers, double missing) {
  EditableMap map;
  map.name = "street";
  map.info.flags = kHasHeightsFlag;
  map.info.index_cell_m = 32.0;
  map.info.length_m = kStreet_m;
  EditableKeyframe keyframe;
  keyframe.record = RecordOf(Pose3{});
  for (const Scatterer& scatterer : scatterers) {
    const Eigen::Vector2d p_m = (1.0 - missing) * scatterer.p_m;
    keyframe.points.push_back({.x_m = static_cast<float>(p_m.x()),
                               .y_m = static_cast<float>(p_m.y()),
                               .z_m = static_cast<float>(scatterer.height_m),
                               .xx_m2 = 0.01F,
                               .xy_m2 = 0.0F,
                               .xz_m2 = 0.0F,
                               .yy_m2 = 0.01F,
                               .yz_m2 = 0.0F,
                               .zz_m2 = 1.0F,
                               .rcs_dbsm = 0.0F,
                               .scan_count = 9,
                               .pass_count = 1});
  }
  map.keyframes.push_back(keyframe);
  return RadarMap::FromBytes(ToMapBytes(map).value()).value();
}

/// What a planar radar at the vehicle's origin sees ahead.
std::vector<RadarPoint> See(const std::vector<Scatterer>& scatterers, double along_m,
                            std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, kRangeNoise_m);
  std::vector<RadarPoint> points;
  for (const Scatterer& scatterer : scatterers) {
    const Eigen::Vector2d sight_m = scatterer.p_m - Eigen::Vector2d(along_m, 0.0);
    if (sight_m.x() < 4.0 || sight_m.x() > 60.0) continue;
    const double range_m = std::hypot(sight_m.norm(), scatterer.height_m) + noise(random);
    RadarPoint point;
    point.position_m << range_m * sight_m.normalized(), 0.0;
    point.covariance_m2 = 0.04 * Eigen::Matrix3d::Identity();
    point.slant_per_m = sight_m.normalized() / (2.0 * range_m);
    points.push_back(point);
  }
  return points;
}

ScaleEstimator Drive(const std::vector<Scatterer>& scatterers, double missing) {
  ScaleEstimator estimator(*MapOf(scatterers, missing));
  std::mt19937 random(7);
  for (int i = 0; i < 300; ++i) {
    const Stamp stamp(std::chrono::seconds(1'700'000'000) + std::chrono::milliseconds(77 * i));
    Pose3 T_map_vehicle;
    T_map_vehicle.translation_m.x() = (1.0 - missing) * i;
    estimator.Add(See(scatterers, i, random), stamp, T_map_vehicle, Pose3{});
  }
  estimator.EndDrive();
  return estimator;
}

class ScaleEstimatorTest : public testing::TestWithParam<double> {};

TEST_P(ScaleEstimatorTest, FindsWhatIsMissingWhateverTheHeights) {
  for (const double max_height_m : {0.0, 6.0}) {
    const auto estimate = Drive(Street(max_height_m), GetParam()).Estimate();
    ASSERT_TRUE(estimate);
    EXPECT_NEAR(estimate->value, GetParam(), 3.0 * std::sqrt(estimate->variance)) << max_height_m;
    EXPECT_LT(std::sqrt(estimate->variance), 0.002);
  }
}

INSTANTIATE_TEST_SUITE_P(Shares, ScaleEstimatorTest, testing::Values(-0.01, 0.0, 0.01));

TEST(ScaleEstimatorTest, SaysNothingOfAFewLandmarks) {
  std::vector<Scatterer> few = Street(3.0);
  few.resize(20);
  EXPECT_FALSE(Drive(few, 0.01).Estimate());
}

TEST(ScaleEstimatorTest, LandmarksTooNearToOneAnotherTellNothing) {
  std::vector<Scatterer> doubled = Street(3.0);
  const std::vector<Scatterer> others = doubled;
  for (Scatterer other : others) {
    other.p_m.y() += 0.5;
    doubled.push_back(other);
  }
  EXPECT_FALSE(Drive(doubled, 0.01).Estimate());
}

}  // namespace
}  // namespace dcloc
