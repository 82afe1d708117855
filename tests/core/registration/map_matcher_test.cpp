#include "core/registration/map_matcher.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "core/registration/gicp_registration.h"
#include "tests/core/localizer/synthetic_world.h"
#include "tests/core/relocalization/seen_points.h"

namespace dcloc {
namespace {

constexpr double kAlong_m = 60.0;

TEST(RegistrationGateTest, EachBoundRefuses) {
  const RegistrationGate gate{
      .min_inlier_count = 10, .min_overlap = 0.2, .max_residual_scale = 1.8};
  Registration<2> one{.inlier_count = 10, .overlap = 0.2, .residual_scale = 1.8};
  EXPECT_TRUE(gate.Accepts(one));
  one.inlier_count = 9;
  EXPECT_FALSE(gate.Accepts(one));
  one = {.inlier_count = 10, .overlap = 0.19, .residual_scale = 1.8};
  EXPECT_FALSE(gate.Accepts(one));
  one = {.inlier_count = 10, .overlap = 0.2, .residual_scale = 1.81};
  EXPECT_FALSE(gate.Accepts(one));
}

// A vehicle that stands on the road, and a matcher whose local map is there.
class MapMatcherTest : public ::testing::Test {
 protected:
  explicit MapMatcherTest(const SyntheticWorld& world = SyntheticWorld())
      : world_(world),
        map_(MapOfDrive(DriveRoad(world_, FrontRadar(), 8.0, 1), FrontRadar())),
        matcher_(map_, std::make_shared<GicpRegistration<2>>(GicpOptions()), {}) {
    EXPECT_TRUE(matcher_.MoveTo(T_map_vehicle_.translation_m, workspace_));
    live_ = SeenFrom(world_, T_map_vehicle_, 60.0, random_);
  }

  Pose2 TrueInLocal() const { return Flatten(matcher_.T_map_local().Inverse() * T_map_vehicle_); }

  // A prediction that is off by `ahead_m`, and that claims to be as good as `sigma_m`.
  PoseEstimate<2> Predicted(double ahead_m, double sigma_m) const {
    return {.pose = TrueInLocal() * Pose2{.translation_m = {ahead_m, 0.0}, .yaw_rad = 0.0},
            .covariance = Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, 1e-4).asDiagonal()};
  }

  std::optional<Registration<2>> Match(const PoseEstimate<2>& predicted) {
    return matcher_.Match(live_, predicted, Observability(), 1, workspace_);
  }

  double ErrorOf(const Registration<2>& registration) const {
    return (registration.T_local_vehicle.translation_m - TrueInLocal().translation_m).norm();
  }

  const SyntheticWorld world_;
  const std::shared_ptr<const RadarMap> map_;
  const Pose3 T_map_vehicle_ = SyntheticWorld::OnRoad(kAlong_m);
  std::mt19937 random_{7};
  RegistrationWorkspace<2> workspace_;
  MapMatcher<2> matcher_;
  std::vector<GaussianPoint<2>> live_;
};

TEST_F(MapMatcherTest, TheFrameChangesWithTheNearestKeyframeAlone) {
  const Pose3 before = matcher_.T_map_local();
  EXPECT_FALSE(matcher_.MoveTo(T_map_vehicle_.translation_m, workspace_));
  EXPECT_FALSE(matcher_.MoveTo({1e5, 0.0, 0.0}, workspace_)) << "there is no map";
  EXPECT_EQ(matcher_.T_map_local().translation_m, before.translation_m);
  EXPECT_TRUE(matcher_.MoveTo(SyntheticWorld::OnRoad(20.0).translation_m, workspace_));
}

TEST_F(MapMatcherTest, ACertainPredictionIsRefined) {
  const auto registration = Match(Predicted(0.3, 0.2));
  ASSERT_TRUE(registration.has_value());
  EXPECT_LT(ErrorOf(*registration), 0.1);
}

TEST_F(MapMatcherTest, AnUncertainOneIsSearchedAround) {
  const auto registration = Match(Predicted(4.0, 1.5));
  ASSERT_TRUE(registration.has_value());
  EXPECT_LT(ErrorOf(*registration), 0.1);
  const auto trusted = Match(Predicted(4.0, 0.1));
  EXPECT_TRUE(!trusted || ErrorOf(*trusted) > 1.0) << "nobody looked further";
}

TEST_F(MapMatcherTest, AlongWhatIsNotObservedNothingIsSearchedFor) {
  PoseEstimate<2> predicted = Predicted(4.0, 0.1);
  predicted.covariance(0, 0) = 2.0;
  Observability along;
  along.directions[0] = {.axis = Eigen::Vector2d::UnitX(), .observed = false};
  const auto refined = matcher_.Match(live_, predicted, along, 1, workspace_);
  EXPECT_TRUE(!refined || ErrorOf(*refined) > 1.0);
  const auto searched = Match(predicted);
  ASSERT_TRUE(searched.has_value());
  EXPECT_LT(ErrorOf(*searched), 0.1);
}

TEST_F(MapMatcherTest, WithoutPointsOrMapThereIsNoRegistration) {
  MapMatcher<2> nowhere(map_, std::make_shared<GicpRegistration<2>>(GicpOptions()), {});
  EXPECT_FALSE(nowhere.Match(live_, Predicted(0.0, 0.1), {}, 1, workspace_).has_value());
  EXPECT_EQ(nowhere.Fit(live_, {}, 0.1, workspace_), 0.0);
  live_.clear();
  EXPECT_FALSE(Match(Predicted(0.0, 0.1)).has_value());
  EXPECT_EQ(matcher_.Fit(live_, TrueInLocal(), 0.1, workspace_), 0.0);
}

TEST_F(MapMatcherTest, PointsFitWhereTheyWereSeen) {
  const double here = matcher_.Fit(live_, TrueInLocal(), 0.1, workspace_);
  const Pose2 beside = TrueInLocal() * Pose2{.translation_m = {1.0, 1.0}, .yaw_rad = 0.0};
  EXPECT_GT(here, 0.25);
  EXPECT_LT(matcher_.Fit(live_, beside, 0.1, workspace_), 0.5 * here);
}

TEST_F(MapMatcherTest, APlaceThatWasFoundMustPassItsOwnGate) {
  const RegistrationGate gate{.min_inlier_count = 20, .min_overlap = 0.3};
  const auto found =
      matcher_.MatchFound(live_, SyntheticWorld::OnRoad(kAlong_m + 0.4), gate, workspace_);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(ErrorOf(*found), 0.1);
  const RegistrationGate strict{.min_inlier_count = 100'000};
  EXPECT_FALSE(matcher_.MatchFound(live_, T_map_vehicle_, strict, workspace_).has_value());
}

// Posts at even distances: a place between two others is as good as they are.
class AmongPostsTest : public MapMatcherTest {
 protected:
  AmongPostsTest() : MapMatcherTest(SyntheticWorld::Posts(6.0)) {}
};

TEST_F(AmongPostsTest, AWidePredictionDecidesNothingThatThePointsLeaveOpen) {
  EXPECT_FALSE(Match(Predicted(3.0, 2.5)).has_value());
  const auto near = Match(Predicted(0.2, 0.2));
  ASSERT_TRUE(near.has_value());
  EXPECT_LT(ErrorOf(*near), 0.2);
}

}  // namespace
}  // namespace dcloc
