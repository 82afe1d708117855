#include "core/relocalization/place_registration.h"

#include <gtest/gtest.h>

#include "core/registration/gicp_registration.h"
#include "tests/core/relocalization/seen_points.h"

namespace dcloc {
namespace {

constexpr RegistrationEffort kEffort{
    .max_iterations = 20, .translation_tolerance_m = 1e-3, .rotation_tolerance_rad = 1e-4};

class PlaceRegistrarTest : public ::testing::Test {
 protected:
  std::optional<PlaceRegistration<2>> Register(const Pose3& guess,
                                               const RegistrationEffort& effort = kEffort) {
    return registrar_.Register(seen_, guess, 0.5, effort, workspace_);
  }

  const SyntheticWorld world_;
  const Pose3 T_map_vehicle_ = SyntheticWorld::OnRoad(60.0);
  std::mt19937 random_{7};
  const std::vector<GaussianPoint<2>> seen_ = SeenFrom(world_, T_map_vehicle_, 60.0, random_);
  PlaceRegistrar<2> registrar_{MapOfDrive(DriveRoad(world_, FrontRadar(), 8.0, 1), FrontRadar()),
                               std::make_shared<GicpRegistration<2>>(GicpOptions()), 100.0};
  RegistrationWorkspace<2> workspace_;
};

TEST_F(PlaceRegistrarTest, FindsThePoseAroundAPlace) {
  const auto found = Register(SyntheticWorld::OnRoad(60.6));
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((found->T_map_vehicle.translation_m - T_map_vehicle_.translation_m).head<2>().norm(),
            0.1);
  EXPECT_GT(found->registration.inlier_count, 25);
}

TEST_F(PlaceRegistrarTest, WithoutAKeyframeWithinReachThereIsNone) {
  EXPECT_FALSE(Register(Embed(Pose2{.translation_m = {0.0, 5e3}, .yaw_rad = 0.0})).has_value());
}

TEST_F(PlaceRegistrarTest, MoreIterationsCostMoreWork) {
  const auto one = Register(
      SyntheticWorld::OnRoad(60.6),
      {.max_iterations = 1, .translation_tolerance_m = 1e-9, .rotation_tolerance_rad = 1e-9});
  const auto more = Register(SyntheticWorld::OnRoad(60.6));
  ASSERT_TRUE(one && more);
  EXPECT_GE(one->work, static_cast<double>(seen_.size()));
  EXPECT_GT(more->work, one->work);
}

TEST_F(PlaceRegistrarTest, PlacesElsewhereDoNotChangeTheResult) {
  const auto first = Register(SyntheticWorld::OnRoad(60.6));
  Register(SyntheticWorld::OnRoad(150.0));
  const auto again = Register(SyntheticWorld::OnRoad(60.6));
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->T_map_vehicle.translation_m, again->T_map_vehicle.translation_m);
  EXPECT_EQ(first->work, again->work);
}

}  // namespace
}  // namespace dcloc
