#include "core/map/packed_lanes.h"

#include <gtest/gtest.h>

#include <array>
#include <type_traits>

namespace dcloc {
namespace {

template <typename T>
class PackedLanesTest : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(PackedLanesTest, Dimensions);

TYPED_TEST(PackedLanesTest, HaveWhatThePointsHave) {
  constexpr int kDim = TypeParam::value;
  std::array<PackedPoint<kDim>, kLaneCount> points;
  for (PackedPoint<kDim>& point : points) {
    point.mean_m.setRandom();
    point.height_square_m2 = 2.0F * point.mean_m(0);
    point.triangle_m2.setRandom();
  }
  const PackedLanes<kDim> lanes(points.data());
  const Eigen::Matrix<float, kDim, 1> p_m = Eigen::Matrix<float, kDim, 1>::Constant(0.7F);
  const Eigen::Matrix<float, kDim, 1> slant_per_m = Eigen::Matrix<float, kDim, 1>::Constant(0.1F);
  const std::array<Lanes, kDim> e_m = lanes.SeenFrom(p_m, slant_per_m);
  for (std::size_t lane = 0; lane < kLaneCount; ++lane) {
    const PackedPoint<kDim>& point = points.at(lane);
    const Eigen::Matrix<float, kDim, 1> expected_m = point.SeenBy(slant_per_m) - p_m;
    const Eigen::Matrix<float, kDim, 1> variances_m2 = point.Variances_m2();
    for (int axis = 0; axis < kDim; ++axis) {
      EXPECT_FLOAT_EQ(e_m.at(static_cast<std::size_t>(axis))[lane], expected_m(axis));
      EXPECT_EQ(lanes.Variances_m2(axis)[lane], variances_m2(axis));
    }
    for (std::size_t i = 0; i < lanes.triangle_m2.size(); ++i) {
      EXPECT_EQ(lanes.triangle_m2.at(i)[lane], point.triangle_m2(static_cast<Eigen::Index>(i)));
    }
  }
}

}  // namespace
}  // namespace dcloc
