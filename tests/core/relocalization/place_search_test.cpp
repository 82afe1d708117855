#include "core/relocalization/place_search.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <span>
#include <vector>

#include "tests/core/map/synthetic_map.h"
#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

constexpr std::uint32_t kPointsPerKeyframe = 30;

// A spiral of streets with landmarks at random places along them.
std::shared_ptr<const RadarMap> RandomStreets(std::size_t keyframe_count) {
  SyntheticMap parts(keyframe_count, kPointsPerKeyframe);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place_m(-15.0F, 15.0F);
  for (MapPoint& point : parts.points) {
    point.x_m = place_m(random);
    point.y_m = place_m(random);
  }
  auto map = RadarMap::FromBytes(parts.Bytes());
  EXPECT_TRUE(map.ok()) << map.status();
  return *std::move(map);
}

// The landmarks within 50 m of the vehicle, seen with 0.2 m of noise.
std::vector<Eigen::Vector2f> Seen(const RadarMap& map, const Pose3& T_map_vehicle) {
  std::mt19937 random(2);
  std::normal_distribution<float> noise_m(0.0F, 0.2F);
  std::vector<Eigen::Vector2f> points;
  const Pose3 T_vehicle_map = T_map_vehicle.Inverse();
  for (const std::size_t index : map.KeyframesWithin(T_map_vehicle.translation_m, 50.0)) {
    const Keyframe keyframe = map.keyframe(index);
    for (const MapPoint& point : keyframe.points) {
      const Eigen::Vector3d p_map =
          keyframe.T_map_keyframe * Eigen::Vector3d(point.x_m, point.y_m, point.z_m);
      points.emplace_back((T_vehicle_map * p_map).head<2>().cast<float>() +
                          Eigen::Vector2f(noise_m(random), noise_m(random)));
    }
  }
  return points;
}

std::vector<PlaceCandidate> Search(const std::shared_ptr<const RadarMap>& map,
                                   std::span<const Eigen::Vector2f> points,
                                   const PlaceSearchOptions& options = {}) {
  PlaceSearch search(map, points, options);
  while (!search.done()) search.SearchOn();
  return search.Best();
}

TEST(PlaceSearchOptionsTest, EachFieldIsBounded) { ExpectEachFieldIsBounded<PlaceSearchOptions>(); }

TEST(PlaceSearchTest, FindsThePlaceAmongManyAndItsHeading) {
  const auto map = RandomStreets(400);
  for (const std::size_t index : {3U, 150U, 399U}) {
    for (const double yaw_rad : {0.3, 3.0, -1.7}) {
      const Pose3 T_map_vehicle = map->keyframe(index).T_map_keyframe *
                                  Embed(Pose2{.translation_m = {3.3, -2.1}, .yaw_rad = yaw_rad});
      const auto places = Search(map, Seen(*map, T_map_vehicle));
      ASSERT_FALSE(places.empty());
      const Pose3 found =
          map->keyframe(places[0].keyframe).T_map_keyframe * Embed(places[0].T_keyframe_vehicle);
      const Pose2 error = Flatten(T_map_vehicle.Inverse() * found);
      EXPECT_LT(error.translation_m.norm(), 1.5) << "keyframe " << index << ", yaw " << yaw_rad;
      EXPECT_LT(std::abs(error.yaw_rad), 0.1);
      EXPECT_GT(places[0].score, 1.2 * places[1].score);
    }
  }
}

TEST(PlaceSearchTest, PlacesAreSortedAndApart) {
  const auto map = RandomStreets(100);
  const auto places = Search(map, Seen(*map, map->keyframe(50).T_map_keyframe), {.max_count = 7});
  ASSERT_EQ(places.size(), 7U);
  for (std::size_t i = 1; i < places.size(); ++i) {
    EXPECT_LE(places[i].score, places[i - 1].score);
    EXPECT_GT(places[i].score, 0.0);
    for (std::size_t j = 0; j < i; ++j) {
      const Pose2 apart = Flatten(
          (map->keyframe(places[i].keyframe).T_map_keyframe * Embed(places[i].T_keyframe_vehicle))
              .Inverse() *
          map->keyframe(places[j].keyframe).T_map_keyframe * Embed(places[j].T_keyframe_vehicle));
      EXPECT_TRUE(apart.translation_m.norm() > 3.9 || std::abs(apart.yaw_rad) > 0.24);
    }
  }
}

TEST(PlaceSearchTest, FindsNothingOutsideOfItsRegion) {
  const auto map = RandomStreets(400);
  const Pose3 T_map_vehicle = map->keyframe(150).T_map_keyframe;
  const std::vector<Eigen::Vector2f> points = Seen(*map, T_map_vehicle);
  SearchRegion region{.centre_m = T_map_vehicle.translation_m.head<2>() + Eigen::Vector2d(5.0, 0.0),
                      .radius_m = 12.0,
                      .yaw_rad = Yaw(T_map_vehicle.rotation) + 0.2,
                      .max_yaw_offset_rad = 0.4};
  const auto found = Search(map, points, {.region = region});
  ASSERT_FALSE(found.empty());
  const Pose3 T_map_found =
      map->keyframe(found[0].keyframe).T_map_keyframe * Embed(found[0].T_keyframe_vehicle);
  EXPECT_LT((T_map_found.translation_m - T_map_vehicle.translation_m).head<2>().norm(), 1.5);

  region.yaw_rad += 2.0;  // the true heading is none of its own
  for (const PlaceCandidate& place : Search(map, points, {.region = region})) {
    EXPECT_LT(place.score, 0.6 * found[0].score);
  }
  region.centre_m = map->keyframe(390).T_map_keyframe.translation_m.head<2>();
  for (const PlaceCandidate& place : Search(map, points, {.region = region})) {
    const Pose3 T_map_place =
        map->keyframe(place.keyframe).T_map_keyframe * Embed(place.T_keyframe_vehicle);
    // Blocks of 16 m that touch the region are searched whole.
    EXPECT_LT((T_map_place.translation_m.head<2>() - region.centre_m).norm(), 12.0 + 23.0);
  }
}

TEST(PlaceSearchTest, FindsWhereAKnownWayLedTo) {
  const auto map = RandomStreets(400);
  const Pose2 T_map_vehicle = Flatten(map->keyframe(150).T_map_keyframe);
  const std::vector<Eigen::Vector2f> points = Seen(*map, map->keyframe(150).T_map_keyframe);
  const Pose2 T_then_now{.translation_m = {60.0, 10.0}, .yaw_rad = 0.7};
  SearchRegion region{.centre_m = (T_map_vehicle * T_then_now.Inverse()).translation_m,
                      .radius_m = 9.0,
                      .max_yaw_offset_rad = 4.0,
                      .T_then_now = T_then_now};
  const auto found = Search(map, points, {.region = region});
  ASSERT_FALSE(found.empty());
  const Pose2 T_map_found =
      Flatten(map->keyframe(found[0].keyframe).T_map_keyframe) * found[0].T_keyframe_vehicle;
  EXPECT_LT((T_map_found.translation_m - T_map_vehicle.translation_m).norm(), 1.5);
  EXPECT_TRUE(region.Contains(T_map_found));
  region.T_then_now.translation_m.x() = 100.0;  // too far for this place
  SearchRegion with_blocks = region;
  with_blocks.radius_m += 23.0;
  EXPECT_FALSE(with_blocks.Contains(T_map_vehicle));
  for (const PlaceCandidate& place : Search(map, points, {.region = region})) {
    const Pose2 T_map_place =
        Flatten(map->keyframe(place.keyframe).T_map_keyframe) * place.T_keyframe_vehicle;
    EXPECT_TRUE(with_blocks.Contains(T_map_place));
  }
}

TEST(PlaceSearchTest, ScoreIsTheShareThatLiesOnLandmarks) {
  const auto map = RandomStreets(30);
  std::vector<Eigen::Vector2f> points = Seen(*map, map->keyframe(10).T_map_keyframe);
  const double all = Search(map, points)[0].score;
  EXPECT_GT(all, 0.6);
  // As many again, where no landmark can be at the same time.
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(600.0F, 5.0F * static_cast<float>(i));
  EXPECT_NEAR(Search(map, points)[0].score, 0.5 * all, 0.1);
}

TEST(PlaceSearchTest, GoesPieceByPieceAndKnowsTheBestSoFar) {
  const auto map = RandomStreets(400);
  const std::vector<Eigen::Vector2f> points = Seen(*map, map->keyframe(200).T_map_keyframe);
  PlaceSearch search(map, points);
  EXPECT_TRUE(search.Best().empty());
  int pieces = 0;
  double best = 0.0;
  for (; !search.done(); ++pieces) {
    search.SearchOn();
    const auto places = search.Best();
    ASSERT_FALSE(places.empty());
    EXPECT_GE(places[0].score, best);
    best = places[0].score;
  }
  // 4 km of street are some hundreds of squares of 16 m, each searched in about a hundred headings;
  // a piece has two thousand of those.
  EXPECT_GT(pieces, 20);
  EXPECT_LT(pieces, 200);
  search.SearchOn();
  EXPECT_EQ(search.Best()[0].score, best) << "there is nothing after the last one";
}

TEST(PlaceSearchTest, NoPointsHaveNoPlace) { EXPECT_TRUE(Search(RandomStreets(5), {}).empty()); }

}  // namespace
}  // namespace dcloc
