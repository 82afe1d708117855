#include "core/relocalization/relocalizer.h"

#include <gtest/gtest.h>

#include <chrono>

#include "core/registration/gicp_registration.h"
#include "tests/core/relocalization/seen_points.h"

namespace dcloc {
namespace {

constexpr auto kLongSpan = std::chrono::seconds(1);

PoseEstimate<3> PriorAround(double along_m, double sigma_m) {
  return {.pose = SyntheticWorld::OnRoad(along_m),
          .covariance = sigma_m * sigma_m * Matrix6d::Identity()};
}

class RelocalizerTest : public ::testing::Test {
 protected:
  static GlobalLocalizerOptions FewPoints() {
    GlobalLocalizerOptions options;
    options.gate.min_inlier_count = 40;
    return options;
  }

  using Place = Relocalizer<2>::Place;

  // Calls as scans come, until a place is found or `count` calls are made.
  std::optional<Place> Search(int count,
                              const std::optional<Relocalizer<2>::ExpectedPlace>& at = {},
                              std::chrono::nanoseconds span = kLongSpan) {
    for (int i = 0; i < count; ++i) {
      stamp_ += std::chrono::milliseconds(77);
      if (auto place = relocalizer_.Search(stamp_, seen_, span, at, workspace_)) return place;
    }
    return std::nullopt;
  }

  const SyntheticWorld world_;
  const Pose3 T_map_vehicle_ = SyntheticWorld::OnRoad(60.0);
  std::mt19937 random_{7};
  std::vector<GaussianPoint<2>> seen_ = SeenFrom(world_, T_map_vehicle_, 60.0, random_);
  Relocalizer<2> relocalizer_{MapOfDrive(DriveRoad(world_, FrontRadar(), 8.0, 1), FrontRadar()),
                              std::make_shared<GicpRegistration<2>>(GicpOptions()),
                              100.0,
                              {},
                              FewPoints()};
  RegistrationWorkspace<2> workspace_;
  Stamp stamp_{std::chrono::seconds(1'700'000'000)};
};

TEST_F(RelocalizerTest, AnExpectedPlaceThatFitsIsFound) {
  const auto place = Search(400, Relocalizer<2>::ExpectedPlace{.T_map_vehicle = T_map_vehicle_});
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(place->origin, PlaceOrigin::kExpected);
  EXPECT_LT((place->T_map_vehicle.translation_m - T_map_vehicle_.translation_m).norm(), 0.3);
}

// Registrations scored more than anything does here: the region around the pose does not verify it.
TEST_F(RelocalizerTest, AnExpectedPlaceThatScoresLessThanUsualIsHeldAgainstTheWholeMap) {
  const Relocalizer<2>::ExpectedPlace expected{.T_map_vehicle = T_map_vehicle_};
  relocalizer_.SetPrior(PriorAround(60.0, 0.5));
  for (int i = 0; i < 100; ++i) relocalizer_.OnRegistered(0.99);
  const auto place = Search(400, expected);
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(place->origin, PlaceOrigin::kExpected);
  EXPECT_FALSE(place->fits_as_usual);
}

TEST_F(RelocalizerTest, AnExpectedPlaceThatScoresAsUsualIsVerifiedInItsRegion) {
  const Relocalizer<2>::ExpectedPlace expected{.T_map_vehicle = T_map_vehicle_};
  relocalizer_.SetPrior(PriorAround(60.0, 0.5));
  for (int i = 0; i < 100; ++i) relocalizer_.OnRegistered(0.1);
  const auto place = Search(400, expected);
  ASSERT_TRUE(place.has_value());
  EXPECT_TRUE(place->fits_as_usual);
}

TEST_F(RelocalizerTest, OneViewWithoutAnExpectationDecidesNothing) {
  EXPECT_FALSE(Search(400).has_value()) << "the vehicle has not moved";
}

TEST_F(RelocalizerTest, TooShortASubmapIsNoView) {
  const Relocalizer<2>::ExpectedPlace here{.T_map_vehicle = T_map_vehicle_};
  EXPECT_FALSE(Search(50, here, std::chrono::nanoseconds(0)).has_value());
  seen_.resize(3);
  EXPECT_FALSE(Search(50, here).has_value()) << "nor is one of few points";
}

// Far from the map nothing looks like what is seen.
TEST_F(RelocalizerTest, WhereTheVehicleComesBackToTheMapTheSearchBeginsAnew) {
  const auto ahead = [](double distance_m) {
    Pose3 T_from_to;
    T_from_to.translation_m.x() = distance_m;
    return T_from_to;
  };
  const auto move = [&](double distance_m) {
    relocalizer_.OnMotion(
        {.T_from_to = ahead(distance_m), .covariance = 1e-6 * Matrix6d::Identity()});
  };
  relocalizer_.SetPrior(
      {.pose = T_map_vehicle_ * ahead(-1000.0), .covariance = Matrix6d::Identity()});
  for (int i = 0; i < 8; ++i) {
    Search(20);
    move(5.0);
  }
  EXPECT_GT(relocalizer_.failed_search_count(), 0);
  move(560.0);
  Search(1);
  EXPECT_GT(relocalizer_.failed_search_count(), 0) << "still far from the map";
  move(400.0);
  Search(1);
  EXPECT_EQ(relocalizer_.failed_search_count(), 0);
}

TEST_F(RelocalizerTest, AFixReplacesAPriorThatIsLessCertain) {
  relocalizer_.OnFix(PriorAround(10.0, 20.0));
  ASSERT_TRUE(relocalizer_.prior().has_value());
  relocalizer_.OnFix(PriorAround(50.0, 30.0));
  EXPECT_EQ(relocalizer_.prior()->pose.translation_m, SyntheticWorld::OnRoad(10.0).translation_m);
  relocalizer_.OnFix(PriorAround(50.0, 5.0));
  EXPECT_EQ(relocalizer_.prior()->pose.translation_m, SyntheticWorld::OnRoad(50.0).translation_m);
}

TEST_F(RelocalizerTest, WhatIsFoundNeedsNoPrior) {
  relocalizer_.SetPrior(PriorAround(60.0, 20.0));
  relocalizer_.OnFound();
  EXPECT_FALSE(relocalizer_.prior().has_value());
}

TEST_F(RelocalizerTest, ThePriorIsCarriedOn) {
  relocalizer_.SetPrior(PriorAround(0.0, 5.0));
  relocalizer_.OnMotion(
      {.T_from_to = SyntheticWorld::OnRoad(30.0), .covariance = 0.01 * Matrix6d::Identity()});
  EXPECT_LT((relocalizer_.prior()->pose.translation_m - SyntheticWorld::OnRoad(30.0).translation_m)
                .norm(),
            1e-9);
}

}  // namespace
}  // namespace dcloc
