#include "core/localizability/alias_finder.h"

#include <gtest/gtest.h>

#include "tests/core/localizability/row_map.h"
#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

/// What a vehicle sees of the landmarks 60 m around it, exactly.
PlaceView ViewAt(double x_m, const std::vector<TestLandmark>& landmarks) {
  PlaceView view{.T_map_vehicle = Embed({{x_m, 0.0}, 0.0}), .points = {}};
  for (const TestLandmark& landmark : landmarks) {
    if (std::abs(landmark.x_m - x_m) > 60.0) continue;
    view.points.push_back({.mean_m = {landmark.x_m - x_m, landmark.y_m},
                           .covariance_m2 = 0.01 * Eigen::Matrix2d::Identity()});
  }
  return view;
}

PlaceLikeness Find(double x_m, std::size_t keyframe_count,
                   const std::vector<TestLandmark>& landmarks) {
  AliasFinder finder(RowMap(keyframe_count, landmarks), {});
  const std::vector<PlaceView> views = {ViewAt(x_m, landmarks), ViewAt(x_m + 10.0, landmarks)};
  return finder.Find(views);
}

TEST(AliasFinderTest, OptionsAreChecked) { ExpectEachFieldIsBounded<AliasOptions>(); }

TEST(AliasFinderTest, AStreetOfItsOwnLooksLikeNothingElse) {
  const PlaceLikeness likeness = Find(150.0, 40, ScatteredPosts(0.0, 400.0));
  EXPECT_FALSE(likeness.is_tunnel);
  EXPECT_FALSE(likeness.alias.has_value());
}

TEST(AliasFinderTest, AStreetThatWasBuiltTwiceIsFoundWithItsTwin) {
  std::vector<TestLandmark> landmarks = ScatteredPosts(0.0, 200.0);
  for (TestLandmark landmark : ScatteredPosts(0.0, 200.0)) {
    landmark.x_m += 300.0;
    landmarks.push_back(landmark);
  }
  const PlaceLikeness likeness = Find(100.0, 50, landmarks);
  EXPECT_FALSE(likeness.is_tunnel);
  ASSERT_TRUE(likeness.alias.has_value());
  EXPECT_NEAR(likeness.alias->T_map_vehicle.translation_m.x(), 400.0, 0.5);
  EXPECT_NEAR(likeness.alias->lead, 0.0, 1.0);
}

TEST(AliasFinderTest, WallsThatRepeatEachMetreAreATunnel) {
  std::vector<TestLandmark> landmarks;
  for (int i = 0; i < 400; ++i) {
    const double x_m = i;
    landmarks.push_back({.x_m = x_m, .y_m = 5.0, .sigma_m = 0.3});
    landmarks.push_back({.x_m = x_m, .y_m = -5.0, .sigma_m = 0.3});
  }
  EXPECT_TRUE(Find(200.0, 40, landmarks).is_tunnel);
}

TEST(AliasFinderTest, WithoutARadiusNothingIsSearched) {
  const std::vector<TestLandmark> landmarks = ScatteredPosts(0.0, 200.0);
  AliasFinder finder(RowMap(20, landmarks), {.radius_m = 0.0});
  const std::vector<PlaceView> views = {ViewAt(100.0, landmarks)};
  EXPECT_FALSE(finder.Find(views).alias.has_value());
  EXPECT_FALSE(finder.Find({}).is_tunnel);
}

}  // namespace
}  // namespace dcloc
