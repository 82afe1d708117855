#include "core/relocalization/pose_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

PoseEstimate<3> About(double sigma_m, double sigma_rad) {
  return {.pose = Embed(Pose2{.translation_m = {100.0, 50.0}, .yaw_rad = 0.5}),
          .covariance = EmbedCovariance(
              Eigen::Vector3d(sigma_m, sigma_m, sigma_rad).cwiseAbs2().asDiagonal(), 0.1, 0.01)};
}

Motion Ahead(double travelled_m) {
  return {.T_from_to = Embed(Pose2{.translation_m = {travelled_m, 0.0}, .yaw_rad = 0.0}),
          .covariance = 0.01 * Matrix6d::Identity()};
}

TEST(PosePriorTest, APriorThatIsGoodEnoughIsAPrediction) {
  const PosePrior prior({.max_prediction_sigma_m = 3.0, .max_prediction_sigma_rad = 0.2});
  EXPECT_TRUE(prior.IsPrediction(About(2.0, 0.1).covariance));
  EXPECT_FALSE(prior.IsPrediction(About(3.0, 0.1).covariance));
  EXPECT_FALSE(prior.IsPrediction(About(1.0, 0.3).covariance));
}

TEST(PosePriorTest, ARegionIsAsLargeAsIsAsked) {
  PosePrior prior({.max_region_radius_m = 150.0});
  prior.Set(About(0.2, 0.01));
  EXPECT_LT(prior.Region(0)->radius_m, 2.0);
  EXPECT_EQ(prior.Region(0, 150.0)->radius_m, 150.0);
  EXPECT_FALSE(prior.Region(0, 151.0).has_value()) << "the whole map";
  EXPECT_EQ(prior.Region(1, 150.0)->radius_m, 150.0) << "not searched yet";
  EXPECT_FALSE(prior.Region(2, 150.0).has_value()) << "in vain";
}

TEST(PosePriorTest, IsCarriedOnByOdometryAndGrows) {
  PosePrior prior({});
  prior.OnMotion(Ahead(5.0));
  EXPECT_FALSE(prior.now().has_value());
  prior.Set(About(2.0, 0.1));
  prior.OnMotion(Ahead(5.0));
  const PoseEstimate<3>& now = *prior.now();
  EXPECT_NEAR(now.pose.translation_m.x(), 100.0 + 5.0 * std::cos(0.5), 1e-9);
  EXPECT_GT(now.covariance(1, 1), 4.0 + 25.0 * 0.01);
  prior.Reset();
  EXPECT_FALSE(prior.now().has_value());
}

TEST(PosePriorTest, TheRegionIsWhatIsLeft) {
  PosePrior prior({});
  EXPECT_FALSE(prior.Region().has_value());
  prior.Set(About(3.0, 0.1));
  const auto region = prior.Region();
  ASSERT_TRUE(region.has_value());
  EXPECT_NEAR(region->radius_m, 10.5, 1e-6);
  EXPECT_NEAR(region->yaw_rad, 0.5, 1e-9);
  EXPECT_NEAR(region->max_yaw_offset_rad, 0.35, 1e-9);
  EXPECT_NEAR(region->centre_m.x(), 100.0, 1e-9);
  const Pose2 T_map_begin = Flatten(About(3.0, 0.1).pose);
  EXPECT_TRUE(region->Contains(T_map_begin));
  EXPECT_FALSE(region->Contains(T_map_begin * Pose2{.translation_m = {11.0, 0.0}, .yaw_rad = 0.0}));
  EXPECT_FALSE(region->Contains(T_map_begin * Pose2{.translation_m = {0.0, 0.0}, .yaw_rad = 0.4}));
}

TEST(PosePriorTest, TheRegionGrowsWithEachSearchInVainToTheWholeMap) {
  PosePrior prior({});
  prior.Set(About(0.5, 0.01));
  const auto first = prior.Region(1);
  ASSERT_TRUE(first.has_value());
  EXPECT_GT(first->radius_m, 30.0);
  EXPECT_GE(first->max_yaw_offset_rad, std::numbers::pi) << "every heading";
  EXPECT_GT(prior.Region(2)->radius_m, 2.0 * first->radius_m);
  EXPECT_FALSE(prior.Region(4).has_value());
}

TEST(PosePriorTest, TheRegionFollowsAndGrowsByOdometry) {
  PosePrior prior({});
  prior.Set(About(3.0, 0.1));
  for (int i = 0; i < 8; ++i) prior.OnMotion(Ahead(5.0));
  const auto region = prior.Region();
  EXPECT_GT(region->radius_m, 10.5);
  EXPECT_LT(region->radius_m, 30.0);
  const Pose2 T_map_begin = Flatten(About(3.0, 0.1).pose);
  EXPECT_TRUE(region->Contains(T_map_begin * Pose2{.translation_m = {40.0, 0.0}, .yaw_rad = 0.0}));
  EXPECT_FALSE(region->Contains(T_map_begin));
}

TEST(PosePriorTest, WithoutAHeadingTheWayDrivenLeavesACircle) {
  PosePrior prior({});
  prior.Set(About(3.0, std::numbers::pi / std::sqrt(3.0)));
  for (int i = 0; i < 8; ++i) prior.OnMotion(Ahead(5.0));
  const auto region = prior.Region();
  ASSERT_TRUE(region.has_value());
  const auto went = [](double yaw_rad, double travelled_m) {
    return Pose2{.translation_m = {100.0, 50.0}, .yaw_rad = yaw_rad} *
           Pose2{.translation_m = {travelled_m, 0.0}, .yaw_rad = 0.0};
  };
  for (const double yaw_rad : {-3.0, -1.0, 0.5, 2.5}) {
    EXPECT_TRUE(region->Contains(went(yaw_rad, 40.0))) << yaw_rad;
    EXPECT_FALSE(region->Contains(went(yaw_rad, 0.0))) << "who drove is not there any more";
    EXPECT_FALSE(region->Contains(went(yaw_rad, -40.0))) << "nor did it drive backwards";
    EXPECT_FALSE(region->Contains(went(yaw_rad, 70.0))) << yaw_rad;
  }
}

TEST(PosePriorTest, TooWideARegionIsTheWholeMap) {
  PosePrior prior({});
  prior.Set(About(200.0, 0.1));
  EXPECT_FALSE(prior.Region().has_value());
}

}  // namespace
}  // namespace dcloc
