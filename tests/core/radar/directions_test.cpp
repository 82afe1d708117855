#include "core/radar/directions.h"

#include <gtest/gtest.h>

#include <vector>

namespace dcloc {
namespace {

Eigen::Vector3d Towards(double azimuth_deg) {
  const double azimuth_rad = azimuth_deg * std::numbers::pi / 180.0;
  return {std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0};
}

TEST(DirectionsTest, EachIsTenDegreesWide) {
  EXPECT_EQ(DirectionOf(Towards(1.0)), DirectionOf(Towards(9.0)));
  EXPECT_EQ(DirectionOf(Towards(11.0)), DirectionOf(Towards(9.0)) + 1);
  EXPECT_EQ(DirectionOf(Towards(-1.0)), DirectionOf(Towards(1.0)) - 1);
}

TEST(DirectionsTest, TheyGoAllAround) {
  for (int i = 0; i < kDirectionCount; ++i) {
    EXPECT_EQ(DirectionOf(Towards(-175.0 + 10.0 * i)), i);
  }
  EXPECT_EQ(DirectionOf({-1.0, 0.0, 0.0}), kDirectionCount - 1);
}

TEST(DirectionsTest, EachCountsOnce) {
  struct Item {
    int direction;
  };
  EXPECT_EQ(CountDirections(std::vector<Item>{{3}, {35}, {3}, {0}}), 3);
  EXPECT_EQ(CountDirections(std::vector<Item>{}), 0);
}

TEST(DirectionsTest, ADirectionThatIsFullSharesItsVotes) {
  struct Item {
    int direction;
    double vote;
  };
  std::vector<Item> items{{4, 0.0}, {4, 0.0}, {4, 0.0}, {4, 0.0}, {9, 0.0}, {20, 0.0}};
  EXPECT_DOUBLE_EQ(ShareVotes(1.0 / 3.0, items), 4.0);
  EXPECT_DOUBLE_EQ(items[0].vote, 0.5);
  EXPECT_DOUBLE_EQ(items[4].vote, 1.0);
}

}  // namespace
}  // namespace dcloc
