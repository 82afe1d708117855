#include "core/registration/correlative_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/core/registration/point_clouds.h"

namespace dcloc {
namespace {

using Vector2fs = std::vector<Eigen::Vector2f>;

struct Scene {
  LocalMap<2> map;
  Vector2fs points;  // the map's, seen from the true pose
};

Scene SceneAt(const Pose2& T_local_vehicle, int count, double noise_m, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<GaussianPoint<2>> landmarks;
  Scene scene;
  for (const Eigen::Vector2d& p_local : SeparatedPoints<2>(count, 40.0, 1.0, random)) {
    landmarks.push_back({p_local, 0.01 * Eigen::Matrix2d::Identity()});
    const Eigen::Vector2d seen =
        T_local_vehicle.Inverse() * p_local + noise_m * StandardNormal<2>(random);
    scene.points.push_back(seen.cast<float>());
  }
  scene.map = LocalMap<2>({}, landmarks);
  return scene;
}

// Distances are counted in whole cells of a grid that has the smallest coordinates on its lines.
double ScoreByHand(const LocalMap<2>& map, const Vector2fs& points, const Pose2& T_local_vehicle,
                   double cell_m) {
  Eigen::Vector2d min_m = map.points()[0].mean_m.cast<double>();
  for (const auto& landmark : map.points()) min_m = min_m.cwiseMin(landmark.mean_m.cast<double>());
  const auto cell_of = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(((p - min_m) / cell_m).array().floor());
  };
  double sum = 0.0;
  for (const Eigen::Vector2f& point : points) {
    const Eigen::Vector2d cell = cell_of(T_local_vehicle * Eigen::Vector2d(point.cast<double>()));
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& landmark : map.points()) {
      nearest = std::min(
          nearest,
          (cell_of(landmark.mean_m.cast<double>() + Eigen::Vector2d::Constant(1e-9)) - cell)
              .norm());
    }
    sum += std::exp(-0.5 * std::pow(nearest / 1.4, 2));
  }
  return sum / static_cast<double>(points.size());
}

TEST(LikelihoodFieldTest, ScoreIsTheMeanLikelihoodOfTheNearestLandmarks) {
  const Scene scene = SceneAt({}, 15, 0.0, 1);
  const LikelihoodField field(scene.map, 0.5);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (int i = 0; i < 300; ++i) {
    const double scale = i < 150 ? 0.3 : 30.0;  // near the truth, and anywhere
    const Pose2 pose{.translation_m = scale * Eigen::Vector2d(place(random), place(random)),
                     .yaw_rad = i < 150 ? 0.02 * place(random) : 3.0 * place(random)};
    // The field keeps a byte per cell, and nothing of what is less than a byte's step.
    EXPECT_NEAR(field.Score(scene.points, pose), ScoreByHand(scene.map, scene.points, pose, 0.5),
                2.0 / 255.0);
  }
  EXPECT_GT(field.Score(scene.points, {}), 0.9);
}

TEST(LikelihoodFieldTest, InSpaceCountsThePlaneOnly) {
  const Scene scene = SceneAt({}, 30, 0.0, 3);
  std::vector<GaussianPoint<3>> raised;
  for (const auto& landmark : scene.map.points()) {
    raised.push_back(
        {{landmark.mean_m.x(), landmark.mean_m.y(), 17.0}, Eigen::Matrix3d::Identity()});
  }
  const LikelihoodField field(LocalMap<3>({}, raised), 0.25);
  const LikelihoodField planar(scene.map, 0.25);
  const Pose2 pose{.translation_m = {0.2, -0.1}, .yaw_rad = 0.01};
  EXPECT_DOUBLE_EQ(field.Score(scene.points, pose), planar.Score(scene.points, pose));
}

TEST(LikelihoodFieldTest, EmptyInputsScoreNothing) {
  const Scene scene = SceneAt({}, 10, 0.0, 4);
  EXPECT_TRUE(LikelihoodField().empty());
  EXPECT_TRUE(LikelihoodField(LocalMap<2>(), 0.5).empty());
  EXPECT_EQ(LikelihoodField(LocalMap<2>(), 0.5).Score(scene.points, {}), 0.0);
  EXPECT_EQ(LikelihoodField(scene.map, 0.5).Score({}, {}), 0.0);
  const Pose2 far{.translation_m = {1e9, -1e9}};
  EXPECT_EQ(LikelihoodField(scene.map, 0.5).Score(scene.points, far), 0.0);
}

TEST(CorrelativeSearchTest, FindsThePoseThreeMetresAndEightDegreesOff) {
  for (unsigned seed = 10; seed < 16; ++seed) {
    const Pose2 truth{.translation_m = {4.0, -7.0}, .yaw_rad = 0.9};
    const Scene scene = SceneAt(truth, 90, 0.1, seed);
    const LikelihoodField field(scene.map, 0.25);
    const double turn_rad = 8.0 * std::numbers::pi / 180.0;
    const Pose2 off{.translation_m = {3.0 * std::cos(seed), 3.0 * std::sin(seed)},
                    .yaw_rad = seed % 2 == 0 ? turn_rad : -turn_rad};
    const SearchWindow window{
        .centre_local_vehicle = {.translation_m = truth.translation_m + off.translation_m,
                                 .yaw_rad = truth.yaw_rad + off.yaw_rad},
        .translation_m = 4.0,
        .rotation_rad = 0.2};
    const auto found = CorrelativeSearch(scene.points, field, window, 3);
    ASSERT_FALSE(found.empty());
    const Pose2 error = truth.Inverse() * found[0].T_local_vehicle;
    // The angle's step moves the farthest points by two cells: half of it, and the position by half
    // of a cell to either side.
    EXPECT_LT(error.translation_m.lpNorm<Eigen::Infinity>(), 0.25) << "seed " << seed;
    EXPECT_LT(std::abs(error.yaw_rad), 0.02) << "seed " << seed;
    EXPECT_DOUBLE_EQ(found[0].score, field.Score(scene.points, found[0].T_local_vehicle));
  }
}

TEST(CorrelativeSearchTest, NoPoseOfTheWindowIsBetterThanTheFirst) {
  const Pose2 truth{.translation_m = {1.0, 2.0}, .yaw_rad = -0.4};
  const Scene scene = SceneAt(truth, 60, 0.1, 20);
  const LikelihoodField field(scene.map, 0.5);
  const SearchWindow window{
      .centre_local_vehicle = truth, .translation_m = 3.0, .rotation_rad = 0.2};
  const auto found = CorrelativeSearch(scene.points, field, window, 1);
  ASSERT_EQ(found.size(), 1U);
  double best = 0.0;
  for (int i = -6; i <= 6; ++i) {
    for (int j = -6; j <= 6; ++j) {
      for (int k = -4; k <= 4; ++k) {
        const Pose2 pose{.translation_m = truth.translation_m + 0.5 * Eigen::Vector2d(i, j),
                         .yaw_rad = truth.yaw_rad + 0.05 * k};
        best = std::max(best, field.Score(scene.points, pose));
      }
    }
  }
  // The same places; angles between its steps may be better by what half a step costs.
  EXPECT_GE(found[0].score, 0.9 * best);
}

TEST(CorrelativeSearchTest, HypothesesAreSortedAndApart) {
  const Scene scene = SceneAt({}, 60, 0.1, 30);
  const LikelihoodField field(scene.map, 0.5);
  const SearchWindow window{.translation_m = 5.0, .rotation_rad = 0.5};
  const auto found = CorrelativeSearch(scene.points, field, window, 12);
  ASSERT_EQ(found.size(), 12U);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i > 0) {
      EXPECT_LE(found[i].score, found[i - 1].score);
    }
    for (std::size_t j = 0; j < i; ++j) {
      const Pose2 apart = found[i].T_local_vehicle.Inverse() * found[j].T_local_vehicle;
      // Within a grid step: a cell, and the angle that moves the farthest points by two.
      EXPECT_TRUE(apart.translation_m.norm() > 0.5 || std::abs(apart.yaw_rad) > 1.0 / 40.0);
    }
  }
}

TEST(CorrelativeSearchTest, EveryHeadingOverAWindowLargerThanTheMap) {
  const Pose2 truth{.translation_m = {2.0, 1.0}, .yaw_rad = 2.9};
  const Scene scene = SceneAt(truth, 60, 0.05, 40);
  const LikelihoodField field(scene.map, 2.0);
  const SearchWindow window{.translation_m = 120.0, .rotation_rad = 10.0};
  const auto found = CorrelativeSearch(scene.points, field, window, 2);
  ASSERT_EQ(found.size(), 2U);
  const Pose2 error = truth.Inverse() * found[0].T_local_vehicle;
  EXPECT_LT(error.translation_m.norm(), 3.0);
  EXPECT_LT(std::abs(error.yaw_rad), 0.15);
}

TEST(CorrelativeSearchTest, TheBestFewAreTheFirstOfMany) {
  const Scene scene = SceneAt({}, 60, 0.1, 35);
  const LikelihoodField field(scene.map, 0.5);
  // So many poses that most are dropped on the way.
  const SearchWindow window{.translation_m = 15.0, .rotation_rad = 1.5};
  const auto many = CorrelativeSearch(scene.points, field, window, 40);
  ASSERT_EQ(many.size(), 40U);
  for (const int count : {1, 2, 7}) {
    const auto few = CorrelativeSearch(scene.points, field, window, count);
    ASSERT_EQ(few.size(), static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < few.size(); ++i) {
      EXPECT_EQ(few[i].score, many[i].score);
      EXPECT_EQ(few[i].T_local_vehicle.translation_m, many[i].T_local_vehicle.translation_m);
      EXPECT_EQ(few[i].T_local_vehicle.yaw_rad, many[i].T_local_vehicle.yaw_rad);
    }
  }
}

TEST(CorrelativeSearchTest, EmptyInputsFindNothing) {
  const Scene scene = SceneAt({}, 10, 0.0, 50);
  const LikelihoodField field(scene.map, 0.5);
  EXPECT_TRUE(CorrelativeSearch({}, field, {}, 3).empty());
  EXPECT_TRUE(CorrelativeSearch(scene.points, LikelihoodField(), {}, 3).empty());
  EXPECT_TRUE(CorrelativeSearch(scene.points, field, {}, 0).empty());
  // A window of no width is its centre.
  const SearchWindow here{.translation_m = 0.0, .rotation_rad = 0.0};
  EXPECT_EQ(CorrelativeSearch(scene.points, field, here, 3).size(), 1U);
}

}  // namespace
}  // namespace dcloc
