#include "core/map/local_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/map/radar_map.h"
#include "tests/core/map/synthetic_map.h"

namespace dcloc {
namespace {

template <typename Dimension>
class LocalMapTest : public ::testing::Test {};

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(LocalMapTest, Dimensions);

template <int Dim>
GaussianPoint<Dim> PointAt(double x_m, double y_m) {
  GaussianPoint<Dim> point;
  point.mean_m.setConstant(0.7);
  point.mean_m.template head<2>() = Eigen::Vector2d(x_m, y_m);
  point.covariance_m2.setIdentity();
  return point;
}

template <int Dim>
LocalMap<Dim> Scattered(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x_m(-30.0, 55.0);
  std::uniform_real_distribution<double> y_m(-12.0, 9.0);
  std::vector<GaussianPoint<Dim>> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) points.push_back(PointAt<Dim>(x_m(random), y_m(random)));
  return LocalMap<Dim>({}, std::move(points));
}

template <int Dim>
std::vector<std::size_t> Visited(const LocalMap<Dim>& map, double x_m, double y_m, double reach_m) {
  std::vector<std::size_t> visited;
  map.ForEachNear(x_m, y_m, reach_m, [&](std::size_t index) { visited.push_back(index); });
  std::sort(visited.begin(), visited.end());
  return visited;
}

TYPED_TEST(LocalMapTest, VisitsEveryPointOfTheSquareOnceAndFewBesides) {
  constexpr int kDim = TypeParam::value;
  constexpr double kLargestCell_m = 5.0;
  const LocalMap<kDim> map = Scattered<kDim>(600, 1);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place_m(-20.0, 20.0);
  std::uniform_real_distribution<double> size_m(0.1, 6.0);
  for (int query = 0; query < 200; ++query) {
    const Eigen::Vector2d centre_m(place_m(random), 0.3 * place_m(random));
    const double reach_m = size_m(random);
    const std::vector<std::size_t> visited = Visited(map, centre_m.x(), centre_m.y(), reach_m);
    EXPECT_EQ(std::adjacent_find(visited.begin(), visited.end()), visited.end());
    for (std::size_t i = 0; i < map.points().size(); ++i) {
      const Eigen::Vector2d away_m =
          map.points()[i].mean_m.template head<2>().template cast<double>() - centre_m;
      const double distance_m = away_m.cwiseAbs().maxCoeff();
      const bool found = std::binary_search(visited.begin(), visited.end(), i);
      if (distance_m <= reach_m) {
        EXPECT_TRUE(found) << "point " << i << " at " << distance_m;
      }
      if (distance_m > reach_m + kLargestCell_m) {
        EXPECT_FALSE(found) << "point " << i << " at " << distance_m;
      }
    }
  }
}

TYPED_TEST(LocalMapTest, SquaresBeyondTheBordersFindWhatTheyCover) {
  constexpr int kDim = TypeParam::value;
  const LocalMap<kDim> map = Scattered<kDim>(50, 3);
  EXPECT_EQ(Visited(map, 0.0, 0.0, 1e9).size(), 50U);
  EXPECT_EQ(Visited(map, -1030.0, 0.0, 1500.0).size(), 50U);
  // What it visits out there is the caller's to refuse; it only must not read outside of the map.
  EXPECT_LE(Visited(map, 1e12, -1e12, 1.0).size(), 50U);
}

TYPED_TEST(LocalMapTest, OnePointAndNone) {
  constexpr int kDim = TypeParam::value;
  const LocalMap<kDim> none;
  EXPECT_TRUE(none.empty());
  EXPECT_TRUE(Visited(none, 0.0, 0.0, 10.0).empty());
  const LocalMap<kDim> one({}, {PointAt<kDim>(4.0, -5.0)});
  EXPECT_FALSE(one.empty());
  EXPECT_EQ(Visited(one, 4.5, -5.5, 1.0).size(), 1U);
}

std::shared_ptr<const RadarMap> Spiral() {
  auto map = RadarMap::FromBytes(SyntheticMap(300, 7).Bytes());
  EXPECT_TRUE(map.ok()) << map.status();
  return *std::move(map);
}

// All landmarks within `radius_m` of keyframe `centre`, in its frame, by looking at every one.
template <int Dim>
std::vector<GaussianPoint<Dim>> AllWithin(const RadarMap& map, std::size_t centre,
                                          double radius_m) {
  std::vector<GaussianPoint<Dim>> within;
  const Pose3 T_local_map = map.keyframe(centre).T_map_keyframe.Inverse();
  for (std::size_t i = 0; i < map.info().keyframe_count; ++i) {
    const Keyframe keyframe = map.keyframe(i);
    const Pose3 T = T_local_map * keyframe.T_map_keyframe;
    for (const MapPoint& point : keyframe.points) {
      const double z_m = map.info().has_heights ? 0.0 : point.z_m;
      const Eigen::Vector3d p_local = T * Eigen::Vector3d(point.x_m, point.y_m, z_m);
      if (p_local.head<2>().norm() > radius_m) continue;
      Eigen::Matrix3d covariance;
      covariance << point.xx_m2, point.xy_m2, point.xz_m2, point.xy_m2, point.yy_m2, point.yz_m2,
          point.xz_m2, point.yz_m2, point.zz_m2;
      const Eigen::Matrix3d turned = T.Rotation() * covariance * T.Rotation().transpose();
      within.push_back({p_local.template head<Dim>(), turned.template topLeftCorner<Dim, Dim>()});
    }
  }
  return within;
}

template <typename Point>
std::vector<Point> Sorted(std::vector<Point> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return std::pair(a.mean_m.x(), a.mean_m.y()) < std::pair(b.mean_m.x(), b.mean_m.y());
  });
  return points;
}

TYPED_TEST(LocalMapTest, JoinsTheLandmarksOfAllKeyframesAround) {
  constexpr int kDim = TypeParam::value;
  const auto map = Spiral();
  for (const std::size_t index : {0U, 40U, 200U}) {
    const Eigen::Vector3d p_map =
        map->keyframe(index).T_map_keyframe.translation_m + Eigen::Vector3d(1.0, -2.0, 0.5);
    const LocalMap<kDim> local(*map, p_map, 60.0);
    EXPECT_TRUE(local.T_map_local().translation_m.isApprox(
        map->keyframe(index).T_map_keyframe.translation_m, 1e-12));

    const auto truth = Sorted(AllWithin<kDim>(*map, index, 60.0));
    const auto points = Sorted(std::vector(local.points().begin(), local.points().end()));
    ASSERT_EQ(points.size(), truth.size());
    EXPECT_GT(points.size(), 5U * 7U) << "more than a few keyframes lie within";
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LT((points[i].mean_m.template cast<double>() - truth[i].mean_m).norm(), 1e-5);
      EXPECT_LT((points[i].Covariance_m2() - truth[i].covariance_m2).norm(), 1e-6);
    }
  }
}

TYPED_TEST(LocalMapTest, LandmarksKnowTheirHeightsWhereTheMapDoes) {
  constexpr int kDim = TypeParam::value;
  SyntheticMap parts(1, 1);
  parts.keyframes[0].translation_local_m = {0.0, 0.0, 0.0};
  parts.keyframes[0].rotation_wxyz = {1.0, 0.0, 0.0, 0.0};
  parts.points[0].z_m = 3.0F;
  parts.index = MakeIndex(parts.keyframes, parts.info.index_cell_m);
  for (const bool has_heights : {false, true}) {
    parts.info.flags = has_heights ? kHasHeightsFlag : 0;
    const auto map = RadarMap::FromBytes(parts.Bytes());
    ASSERT_TRUE(map.ok()) << map.status();
    EXPECT_EQ((*map)->info().has_heights, has_heights);
    const LocalMap<kDim> local(**map, (*map)->keyframe(0).T_map_keyframe.translation_m, 100.0);
    ASSERT_EQ(local.points().size(), 1U);
    EXPECT_EQ(local.points()[0].height_square_m2, has_heights ? 9.0F : 0.0F);
  }
}

TYPED_TEST(LocalMapTest, ALandmarkWithinTheRadiusCountsHoweverFarItsKeyframe) {
  constexpr int kDim = TypeParam::value;
  // Two keyframes 160 m apart; the second one's landmark lies 90 m from the first.
  SyntheticMap parts(2, 1);
  parts.keyframes[0].translation_local_m = {0.0, 0.0, 0.0};
  parts.keyframes[1].translation_local_m = {160.0, 0.0, 0.0};
  for (KeyframeRecord& keyframe : parts.keyframes) keyframe.rotation_wxyz = {1.0, 0.0, 0.0, 0.0};
  parts.points[0].x_m = 10.0F;
  parts.points[1].x_m = -70.0F;
  parts.index = MakeIndex(parts.keyframes, parts.info.index_cell_m);
  const auto map = RadarMap::FromBytes(parts.Bytes());
  ASSERT_TRUE(map.ok()) << map.status();
  const Eigen::Vector3d p_map = (*map)->keyframe(0).T_map_keyframe.translation_m;
  EXPECT_EQ((LocalMap<kDim>(**map, p_map, 100.0).points().size()), 2U);
  EXPECT_EQ((LocalMap<kDim>(**map, p_map, 80.0).points().size()), 1U);
}

TYPED_TEST(LocalMapTest, FarFromTheMapIsEmpty) {
  constexpr int kDim = TypeParam::value;
  const auto map = Spiral();
  const Eigen::Vector3d p_map = map->keyframe(0).T_map_keyframe.translation_m;
  EXPECT_TRUE((LocalMap<kDim>(*map, p_map - Eigen::Vector3d(5000.0, 0.0, 0.0), 60.0).empty()));
  EXPECT_TRUE((LocalMap<kDim>(*map, Eigen::Vector3d::Constant(1e300), 60.0).empty()));
  EXPECT_FALSE((LocalMap<kDim>(*map, p_map, 60.0).empty()));
}

}  // namespace
}  // namespace dcloc
