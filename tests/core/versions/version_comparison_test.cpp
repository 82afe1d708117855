#include "core/versions/version_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/passes/street_fixture.h"

namespace dcloc {
namespace {

TEST(VersionComparisonTest, ARefinedLandmarkIsTheSame) {
  const EditableMap before = TestStreet().Map(0);
  EditableMap after = before;
  for (EditableKeyframe& keyframe : after.keyframes) {
    for (MapPoint& point : keyframe.points) point.x_m += 0.05F;
  }
  const VersionComparison comparison = CompareVersions(before, after, 0.5, PlaceSet({}));
  EXPECT_EQ(comparison.common.size(), before.PointCount());
  EXPECT_TRUE(comparison.removed.empty());
  EXPECT_TRUE(comparison.added.empty());
}

TEST(VersionComparisonTest, WhatOnlyOneVersionHasWentOrCame) {
  TestStreet street;
  const EditableMap before = street.Map(0);
  street.scatterers_m[30] += Eigen::Vector2d(2.0, 3.0);
  const EditableMap after = street.Map(0);
  const VersionComparison comparison = CompareVersions(before, after, 0.5, PlaceSet({}));
  EXPECT_EQ(comparison.removed.size(), 1U);
  EXPECT_EQ(comparison.added.size(), 1U);
  ASSERT_FALSE(comparison.removed.empty());
  const Eigen::Vector2d went_m = comparison.removed.front().position.position_m;
  const VersionComparison by_place = CompareVersions(before, after, 0.5, PlaceSet({went_m}));
  EXPECT_TRUE(by_place.removed.empty());
  EXPECT_EQ(by_place.intermittent.size(), 1U);
  EXPECT_EQ(by_place.common.size(), comparison.common.size());
}

TEST(PlaceSetTest, TellsWhetherOneIsNear) {
  const PlaceSet places({{1.0, 2.0}, {5.0, 5.0}});
  EXPECT_TRUE(places.HasNear({1.3, 2.4}, 0.5));
  EXPECT_FALSE(places.HasNear({1.4, 2.4}, 0.5));
  EXPECT_FALSE(PlaceSet({}).HasNear({1.0, 2.0}, 100.0));
}

}  // namespace
}  // namespace dcloc
