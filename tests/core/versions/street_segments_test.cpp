#include "core/versions/street_segments.h"

#include <gtest/gtest.h>

#include "tests/core/passes/street_fixture.h"

namespace dcloc {
namespace {

TEST(StreetSegmentsTest, AStreetIsDividedByItsLength) {
  const StreetSegments segments(TestStreet().Map(0), 100.0);
  EXPECT_GE(segments.count(), 2U);
  EXPECT_EQ(segments.At({5.0, 3.0}), 0U);
  EXPECT_EQ(segments.At({150.0, -3.0}), 1U);
  EXPECT_NEAR(segments.Middle(0).x(), 45.0, 10.0);
}

}  // namespace
}  // namespace dcloc
