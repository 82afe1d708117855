#include "core/registration/rigid_ransac.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

struct Pairs {
  std::vector<Eigen::Vector2f> a;
  std::vector<Eigen::Vector2f> b;
  std::vector<IndexPair> pairs;
};

// `count` pairs of which the first `true_count` follow `T_a_b` up to `noise_m`.
Pairs MakePairs(const Pose2& T_a_b, int count, int true_count, float noise_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place_m(-40.0F, 40.0F);
  std::normal_distribution<float> noise;
  Pairs result;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f p_b(place_m(random), place_m(random));
    const Eigen::Vector2f jitter(noise_m * noise(random), noise_m * noise(random));
    const Eigen::Vector2f follows = (T_a_b * Eigen::Vector2d(p_b.cast<double>())).cast<float>();
    const Eigen::Vector2f elsewhere(place_m(random), place_m(random));
    result.b.push_back(p_b);
    result.a.push_back(i < true_count ? Eigen::Vector2f(follows + jitter) : elsewhere);
    result.pairs.push_back({static_cast<std::size_t>(i), static_cast<std::size_t>(i)});
  }
  std::shuffle(result.pairs.begin(), result.pairs.end(), random);
  return result;
}

TEST(RigidRansacOptionsTest, EachFieldIsBounded) { ExpectEachFieldIsBounded<RigidRansacOptions>(); }

TEST(RigidRansacTest, FindsAMotionAmongSixtyPercentOutliers) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Pose2 truth{.translation_m = {12.0, -5.0 + seed}, .yaw_rad = 0.6 * seed - 3.0};
    const Pairs input = MakePairs(truth, 100, 40, 0.1F, seed);
    const auto match = MatchRigid(input.a, input.b, input.pairs, seed);
    ASSERT_TRUE(match.has_value()) << "seed " << seed;
    const Pose2 error = truth.Inverse() * match->T_a_b;
    // Forty pairs with 0.1 m noise, some 30 m away: 0.02 m and 0.0007 rad; four times that.
    EXPECT_LT(error.translation_m.norm(), 0.08) << "seed " << seed;
    EXPECT_LT(std::abs(error.yaw_rad), 0.003) << "seed " << seed;
    int true_inliers = 0;
    for (const IndexPair& pair : match->inliers) true_inliers += pair.a < 40;
    EXPECT_GE(true_inliers, 39) << "seed " << seed;
    EXPECT_LE(match->inliers.size(), 43U) << "seed " << seed;
  }
}

TEST(RigidRansacTest, InliersAreThePairsThatFollowTheMotion) {
  const Pairs input = MakePairs({.translation_m = {3.0, 4.0}, .yaw_rad = 1.0}, 60, 30, 0.3F, 20);
  const RigidRansacOptions options{.inlier_distance_m = 0.5};
  const auto match = MatchRigid(input.a, input.b, input.pairs, 1, options);
  ASSERT_TRUE(match.has_value());
  std::size_t following = 0;
  for (const IndexPair& pair : input.pairs) {
    const Eigen::Vector2d moved = match->T_a_b * Eigen::Vector2d(input.b[pair.b].cast<double>());
    following += (moved - input.a[pair.a].cast<double>()).norm() <= 0.5;
  }
  EXPECT_EQ(match->inliers.size(), following);
}

TEST(RigidRansacTest, TheSameSeedGivesTheSameAnswer) {
  const Pairs input = MakePairs({.translation_m = {1.0, 2.0}, .yaw_rad = 0.5}, 80, 25, 0.2F, 30);
  const auto first = MatchRigid(input.a, input.b, input.pairs, 77);
  const auto second = MatchRigid(input.a, input.b, input.pairs, 77);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_a_b.translation_m, second->T_a_b.translation_m);
  EXPECT_EQ(first->T_a_b.yaw_rad, second->T_a_b.yaw_rad);
  ASSERT_EQ(first->inliers.size(), second->inliers.size());
  for (std::size_t i = 0; i < first->inliers.size(); ++i) {
    EXPECT_EQ(first->inliers[i].a, second->inliers[i].a);
  }
}

TEST(RigidRansacTest, NothingWhenTooFewAgree) {
  const Pose2 truth{.translation_m = {1.0, 2.0}, .yaw_rad = 0.5};
  const Pairs few = MakePairs(truth, 40, 8, 0.05F, 40);
  EXPECT_TRUE(MatchRigid(few.a, few.b, few.pairs, 1, {.min_inlier_count = 6}).has_value());
  EXPECT_FALSE(MatchRigid(few.a, few.b, few.pairs, 1, {.min_inlier_count = 20}).has_value());
  const Pairs none = MakePairs(truth, 30, 0, 0.0F, 41);
  EXPECT_FALSE(MatchRigid(none.a, none.b, none.pairs, 1, {.min_inlier_count = 8}).has_value());
}

TEST(RigidRansacTest, TheMotionHasTheInliersAskedForAfterTheFitToo) {
  // Small sets with gross noise, where the fit may lose what the two-pair hypothesis held.
  for (unsigned seed = 0; seed < 300; ++seed) {
    const Pairs input = MakePairs({.translation_m = {1.0, 0.0}}, 12, 8, 0.6F, seed);
    const RigidRansacOptions options{.iterations = 100, .min_inlier_count = 6};
    const auto match = MatchRigid(input.a, input.b, input.pairs, seed, options);
    if (match) {
      EXPECT_GE(match->inliers.size(), 6U) << "seed " << seed;
    }
  }
}

TEST(RigidRansacTest, PointsInOnePlaceGiveNoHeading) {
  Pairs input;
  for (std::size_t i = 0; i < 20; ++i) {
    input.a.emplace_back(5.0F + 0.05F * static_cast<float>(i), 0.0F);
    input.b.emplace_back(0.0F, 0.05F * static_cast<float>(i));
    input.pairs.push_back({i, i});
  }
  EXPECT_FALSE(MatchRigid(input.a, input.b, input.pairs, 1).has_value());
}

TEST(RigidRansacTest, FewPairsAndNone) {
  const Pairs input = MakePairs({}, 10, 10, 0.0F, 50);
  EXPECT_FALSE(MatchRigid(input.a, input.b, {}, 1).has_value());
  EXPECT_FALSE(MatchRigid(input.a, input.b, std::span(input.pairs).first(1), 1).has_value());
}

}  // namespace
}  // namespace dcloc
