#include "core/update/version_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/update/street_fixture.h"

namespace dcloc {
namespace {

TEST(VersionComparisonTest, ARefinedLandmarkIsTheSame) {
  const EditableMap before = TestStreet().Map(0);
  EditableMap after = before;
  for (EditableKeyframe& keyframe : after.keyframes) {
    for (MapPoint& point : keyframe.points) point.x_m += 0.05F;
  }
  const VersionComparison comparison = CompareVersions(before, after, 0.5);
  EXPECT_EQ(comparison.common.size(), before.PointCount());
  EXPECT_TRUE(comparison.removed.empty());
  EXPECT_TRUE(comparison.added.empty());
}

TEST(VersionComparisonTest, WhatOnlyOneVersionHasWentOrCame) {
  TestStreet street;
  const EditableMap before = street.Map(0);
  street.scatterers_m[30] += Eigen::Vector2d(2.0, 3.0);
  const VersionComparison comparison = CompareVersions(before, street.Map(0), 0.5);
  EXPECT_EQ(comparison.removed.size(), 1U);
  EXPECT_EQ(comparison.added.size(), 1U);
}

}  // namespace
}  // namespace dcloc
