#include "core/relocalization/global_localizer.h"

#include <gtest/gtest.h>

#include <chrono>

#include "core/registration/gicp_registration.h"
#include "tests/core/localizer/synthetic_world.h"
#include "tests/core/relocalization/seen_points.h"

namespace dcloc {
namespace {

constexpr double kSpeed_mps = 8.0;
constexpr double kRadius_m = 100.0;

std::shared_ptr<const RadarMap> MapOf(const SyntheticWorld& world) {
  return MapOfDrive(DriveRoad(world, FrontRadar(), kSpeed_mps, 1), FrontRadar());
}

// What stands in these worlds is little.
GlobalLocalizerOptions FewPoints() {
  GlobalLocalizerOptions options;
  options.gate.min_inlier_count = 40;
  return options;
}

// 45 m that follow twice, `apart_m` from one another, and nothing behind the second time.
SyntheticWorld Twins(double apart_m) {
  SyntheticWorld world;
  world.scatterers_m.clear();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> along_m(30.0, 75.0);
  std::uniform_real_distribution<double> aside_m(3.0, 25.0);
  for (int i = 0; i < 150; ++i) {
    const double at_m = along_m(random);
    const Eigen::Vector3d p_road(0.0, i % 2 == 0 ? aside_m(random) : -aside_m(random), 0.0);
    world.scatterers_m.push_back(SyntheticWorld::OnRoad(at_m) * p_road);
    world.scatterers_m.push_back(SyntheticWorld::OnRoad(at_m + apart_m) * p_road);
  }
  return world;
}

using Place = GlobalLocalizer<2>::Place;
using ExpectedPlace = GlobalLocalizer<2>::ExpectedPlace;
using Basis = GlobalLocalizer<2>::Basis;

// A vehicle on the road that is looked for.
class Seeker {
 public:
  Seeker(const SyntheticWorld& world, const std::shared_ptr<const RadarMap>& map, double along_m,
         double sight_m = 60.0, const GlobalLocalizerOptions& options = FewPoints())
      : world_(world),
        global_localizer_(map, std::make_shared<GicpRegistration<2>>(GicpOptions()), kRadius_m,
                          options),
        along_m_(along_m),
        sight_m_(sight_m) {}

  std::optional<Pose3> Continue() { return PoseOf(global_localizer_.Continue(workspace_)); }
  Pose3 T_map_vehicle() const { return SyntheticWorld::OnRoad(along_m_); }
  bool WantsView() const { return global_localizer_.WantsView(stamp_); }

  void DriveTo(double along_m, double sigma_m = 0.1, double spread_m = 0.0) {
    const Pose3 T_from_to = T_map_vehicle().Inverse() * SyntheticWorld::OnRoad(along_m);
    Matrix6d covariance = 1e-6 * Matrix6d::Identity();
    covariance.topLeftCorner<3, 3>().diagonal().setConstant(sigma_m * sigma_m);
    Matrix6d spread = Matrix6d::Zero();
    spread(0, 0) = spread_m * spread_m;
    global_localizer_.OnMotion({.T_from_to = T_from_to, .covariance = covariance + spread}, spread);
    along_m_ = along_m;
    stamp_ += std::chrono::seconds(1);
  }

  // Does all the work on what is seen here.
  std::optional<Pose3> Search(const std::optional<SearchRegion>& region = std::nullopt) {
    return PoseOf(SearchExpecting(std::nullopt, region));
  }

  // Does all the work on what would be seen in another world.
  std::optional<Pose3> SearchSeeing(const SyntheticWorld& other) {
    global_localizer_.AddView(stamp_, SeenFrom(other, T_map_vehicle(), sight_m_, random_), {}, {},
                              usual_score_);
    while (global_localizer_.working()) {
      if (const auto place = global_localizer_.Continue(workspace_)) return PoseOf(place);
    }
    return std::nullopt;
  }

  // The same while it is expected to be somewhere.
  std::optional<Place> SearchExpecting(const std::optional<ExpectedPlace>& expected,
                                       const std::optional<SearchRegion>& region = std::nullopt) {
    global_localizer_.AddView(stamp_, Seen(), region, expected, usual_score_);
    while (global_localizer_.working()) {
      if (auto place = global_localizer_.Continue(workspace_)) return place;
    }
    return std::nullopt;
  }

  /// As registrations did before the vehicle was lost.
  void SetUsualScore(double score) { usual_score_ = score; }

  int failed_search_count() const { return global_localizer_.failed_search_count(); }

  double ErrorOf(const Pose3& found) const {
    return (found.translation_m - T_map_vehicle().translation_m).head<2>().norm();
  }

 private:
  static std::optional<Pose3> PoseOf(const std::optional<Place>& place) {
    return place ? std::optional(place->T_map_vehicle) : std::nullopt;
  }

  std::vector<GaussianPoint<2>> Seen() {
    return SeenFrom(world_, T_map_vehicle(), sight_m_, random_);
  }

  const SyntheticWorld& world_;
  GlobalLocalizer<2> global_localizer_;
  RegistrationWorkspace<2> workspace_;
  std::mt19937 random_{7};
  double along_m_;
  double sight_m_;
  double usual_score_ = 0.0;  // nothing is known of it
  Stamp stamp_{std::chrono::seconds(1'700'000'000)};
};

TEST(GlobalLocalizerTest, APlaceThatHoldsOverNewGroundIsFound) {
  const SyntheticWorld world;
  Seeker seeker(world, MapOf(world), 40.0);
  EXPECT_TRUE(seeker.WantsView());
  EXPECT_FALSE(seeker.Search());
  EXPECT_FALSE(seeker.WantsView()) << "the same again";
  seeker.DriveTo(46.0);
  ASSERT_TRUE(seeker.WantsView());
  EXPECT_FALSE(seeker.Search()) << "six metres are not ten";
  EXPECT_FALSE(seeker.WantsView()) << "and yet it is decided";
  seeker.DriveTo(51.0);
  const auto found = seeker.Continue();
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(seeker.ErrorOf(*found), 0.3);
}

TEST(GlobalLocalizerTest, APlaceOfFewPointsIsNotAccepted) {
  const SyntheticWorld world;
  GlobalLocalizerOptions options = FewPoints();
  options.gate.min_inlier_count = 1000;
  Seeker seeker(world, MapOf(world), 30.0, 60.0, options);
  for (const double along_m : {30.0, 41.0, 52.0, 63.0}) {
    seeker.DriveTo(along_m);
    EXPECT_FALSE(seeker.Search()) << "at " << along_m;
  }
}

TEST(GlobalLocalizerTest, ViewsThatFitNowhereAreForgottenOnceOneFitsAsUsual) {
  const SyntheticWorld world;
  const SyntheticWorld elsewhere = Twins(55.0);
  for (const double usual_score : {0.0, 0.2}) {
    Seeker seeker(world, MapOf(world), 40.0);
    seeker.SetUsualScore(usual_score);
    for (const double along_m : {46.0, 52.0, 58.0}) {
      EXPECT_FALSE(seeker.SearchSeeing(elsewhere));
      seeker.DriveTo(along_m);
    }
    EXPECT_FALSE(seeker.Search());
    seeker.DriveTo(64.0);
    EXPECT_FALSE(seeker.Search()) << "six metres are not ten";
    seeker.DriveTo(69.0);
    const auto found = seeker.Continue();
    ASSERT_EQ(found.has_value(), usual_score > 0.0);
    if (found) {
      EXPECT_LT(seeker.ErrorOf(*found), 0.3);
    }
  }
}

TEST(GlobalLocalizerTest, ViewsAreRareWhereNothingFitsAndFrequentOnceOneDoes) {
  const SyntheticWorld world;
  const SyntheticWorld elsewhere = Twins(55.0);
  GlobalLocalizerOptions options = FewPoints();
  options.early_view_count = 2;
  options.late_view_interval_factor = 8;      // more than three seconds
  options.entering_view_interval_factor = 4;  // more than one
  for (const double usual_score : {0.0, 0.2}) {
    Seeker seeker(world, MapOf(world), 20.0, 60.0, options);
    seeker.SetUsualScore(usual_score);
    const auto drive_on = [&](double along_m) {  // a second
      seeker.DriveTo(along_m);
      return seeker.WantsView();
    };
    EXPECT_FALSE(seeker.SearchSeeing(elsewhere));
    ASSERT_TRUE(drive_on(25.0));
    EXPECT_FALSE(seeker.SearchSeeing(elsewhere));
    for (const double along_m : {30.0, 35.0, 40.0}) EXPECT_FALSE(drive_on(along_m));
    ASSERT_TRUE(drive_on(45.0));
    EXPECT_FALSE(seeker.Search()) << "the map is entered";
    EXPECT_EQ(drive_on(50.0), usual_score > 0.0);
    EXPECT_TRUE(drive_on(55.0));
  }
}

TEST(GlobalLocalizerTest, StandingStillDecidesNothing) {
  const SyntheticWorld world;
  Seeker seeker(world, MapOf(world), 40.0);
  EXPECT_FALSE(seeker.Search());
  for (int i = 0; i < 60; ++i) {
    seeker.DriveTo(40.0, 0.01);
    EXPECT_FALSE(seeker.WantsView());
    EXPECT_FALSE(seeker.Continue());
  }
}

TEST(GlobalLocalizerTest, AmongPostsThatLookAlikeNothingWins) {
  const SyntheticWorld world = SyntheticWorld::Posts(6.0);
  Seeker seeker(world, MapOf(world), 20.0);
  for (const double along_m : {20.0, 31.0, 42.0, 53.0, 64.0, 75.0}) {
    seeker.DriveTo(along_m);
    EXPECT_FALSE(seeker.Search()) << "at " << along_m;
  }
}

TEST(GlobalLocalizerTest, TwinsAreDistinguishedByWhatFollows) {
  constexpr double kApart_m = 65.0;
  const SyntheticWorld world = Twins(kApart_m);
  const auto map = MapOf(world);
  Seeker seeker(world, map, 27.0, 35.0);
  EXPECT_FALSE(seeker.Search());
  seeker.DriveTo(38.0);
  EXPECT_FALSE(seeker.Search()) << "what it sees stands twice in the map";
  seeker.DriveTo(90.0);
  const auto found = seeker.Search();
  ASSERT_TRUE(found.has_value())
      << "behind the first one it goes on, behind the second one it does not";
  EXPECT_LT(seeker.ErrorOf(*found), 0.3);
}

TEST(GlobalLocalizerTest, OneViewVerifiesAPlaceThatIsExpectedRightly) {
  const SyntheticWorld world;
  for (const Basis basis : {Basis::kPrior, Basis::kSuspect}) {
    Seeker seeker(world, MapOf(world), 40.0);
    const auto place = seeker.SearchExpecting(
        ExpectedPlace{.T_map_vehicle = seeker.T_map_vehicle(), .basis = basis});
    ASSERT_TRUE(place.has_value());
    EXPECT_EQ(place->origin, PlaceOrigin::kExpected);
    EXPECT_LT(seeker.ErrorOf(place->T_map_vehicle), 0.3);
  }
}

TEST(GlobalLocalizerTest, AWrongExpectationYieldsToThePlaceThatFits) {
  const SyntheticWorld world;
  for (const double wrong_m : {6.0, 20.0, 60.0}) {
    Seeker seeker(world, MapOf(world), 40.0);
    std::optional<Place> place;
    for (const double along_m : {40.0, 46.0, 52.0, 58.0}) {
      seeker.DriveTo(along_m);
      const Pose3 T_map_wrong = SyntheticWorld::OnRoad(along_m + wrong_m);
      place = seeker.SearchExpecting(ExpectedPlace{T_map_wrong, Basis::kPrior});
      if (place) break;
    }
    ASSERT_TRUE(place.has_value()) << wrong_m;
    EXPECT_EQ(place->origin, PlaceOrigin::kFound) << wrong_m;
    EXPECT_LT(seeker.ErrorOf(place->T_map_vehicle), 0.3) << wrong_m;
  }
}

// The first one is expected, and both fit. By chance the other one may fit a little better.
TEST(GlobalLocalizerTest, AmongTwinsAPriorDecidesOnceAllViewsAreTaken) {
  constexpr double kApart_m = 65.0;
  const SyntheticWorld world = Twins(kApart_m);
  const auto map = MapOf(world);
  Seeker seeker(world, map, 27.0, 35.0);
  std::optional<Place> place;
  for (const double along_m : {27.0, 31.0, 35.0, 39.0}) {
    seeker.DriveTo(along_m);
    place = seeker.SearchExpecting(ExpectedPlace{seeker.T_map_vehicle(), Basis::kPrior});
    if (place) break;
  }
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(place->origin, PlaceOrigin::kExpected);
  EXPECT_LT(seeker.ErrorOf(place->T_map_vehicle), 0.3);
}

// It fits two thirds as well as the place where the vehicle is.
TEST(GlobalLocalizerTest, APriorThatIsOnePostOffIsNotBelieved) {
  SyntheticWorld world = SyntheticWorld::Posts(4.0);
  const SyntheticWorld others;
  for (std::size_t i = 0; i < others.scatterers_m.size(); i += 8) {
    world.scatterers_m.push_back(others.scatterers_m[i]);
  }
  for (const double wrong_m : {-8.0, -6.0, -4.0, 4.0, 6.0, 8.0}) {
    Seeker seeker(world, MapOf(world), 40.0);
    std::optional<Place> place;
    for (const double along_m : {40.0, 44.0, 48.0, 52.0}) {
      seeker.DriveTo(along_m);
      const Pose3 T_map_wrong = SyntheticWorld::OnRoad(along_m + wrong_m);
      place = seeker.SearchExpecting(ExpectedPlace{T_map_wrong, Basis::kPrior});
      if (place) break;
    }
    if (place) {
      EXPECT_LT(seeker.ErrorOf(place->T_map_vehicle), 0.3) << wrong_m;
    }
  }
}

TEST(GlobalLocalizerTest, ARegionWhereNothingFitsIsSearchedInVain) {
  const SyntheticWorld world;
  Seeker seeker(world, MapOf(world), 30.0);
  const SearchRegion region{.centre_m = SyntheticWorld::OnRoad(120.0).translation_m.head<2>(),
                            .radius_m = 12.0,
                            .max_yaw_offset_rad = std::numbers::pi};
  for (const double along_m : {30.0, 41.0, 52.0}) {
    seeker.DriveTo(along_m);
    seeker.Search(region);
  }
  EXPECT_GE(seeker.failed_search_count(), 1);
}

TEST(GlobalLocalizerTest, NothingIsFoundInAWrongRegion) {
  const SyntheticWorld world;
  Seeker seeker(world, MapOf(world), 30.0);
  const SearchRegion region{.centre_m = SyntheticWorld::OnRoad(120.0).translation_m.head<2>(),
                            .radius_m = 12.0,
                            .max_yaw_offset_rad = std::numbers::pi};
  for (const double along_m : {30.0, 41.0, 52.0, 63.0, 74.0}) {
    seeker.DriveTo(along_m);
    EXPECT_FALSE(seeker.Search(region)) << "at " << along_m;
  }
}

TEST(GlobalLocalizerTest, WhatOdometryDoesNotJoinIsForgotten) {
  const SyntheticWorld world;
  Seeker seeker(world, MapOf(world), 40.0);
  EXPECT_FALSE(seeker.Search());
  seeker.DriveTo(41.0, 3.0);
  EXPECT_TRUE(seeker.WantsView()) << "as at the beginning";
  EXPECT_FALSE(seeker.Search());
  seeker.DriveTo(52.0);
  const auto found = seeker.Search();
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(seeker.ErrorOf(*found), 0.3);
}

TEST(GlobalLocalizerTest, SourcesThatDifferDoNotPartTheViews) {
  const SyntheticWorld world;
  Seeker seeker(world, MapOf(world), 40.0);
  EXPECT_FALSE(seeker.Search());
  seeker.DriveTo(52.0, 0.1, 3.0);
  const auto found = seeker.Search();
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(seeker.ErrorOf(*found), 0.3);
}

}  // namespace
}  // namespace dcloc
