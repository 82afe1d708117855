#include "core/versions/block_mean.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dcloc {
namespace {

TEST(BlockMeanTest, IsTheMeanOfAllValues) {
  BlockMean mean(4);
  EXPECT_EQ(mean.mean(), 0.0);
  for (const double value : {1.0, 2.0, 3.0, 4.0, 5.0}) mean.Add(value);
  EXPECT_DOUBLE_EQ(mean.mean(), 3.0);
}

TEST(BlockMeanTest, SaysNothingOfItsErrorWithFewBlocks) {
  BlockMean mean(2);
  for (int i = 0; i < 5; ++i) mean.Add(i);
  EXPECT_TRUE(std::isinf(mean.sigma()));
  mean.Add(5.0);
  EXPECT_DOUBLE_EQ(mean.sigma(), std::sqrt(4.0 / 3.0));  // of 0.5, 2.5 and 4.5
}

TEST(BlockMeanTest, NeighboursThatAreAlikeMakeItNoMoreCertain) {
  BlockMean once(1);
  BlockMean often(10);
  for (const double value : {1.0, -1.0, 2.0, -2.0, 3.0, -3.0}) {
    once.Add(value);
    for (int i = 0; i < 10; ++i) often.Add(value);
  }
  EXPECT_NEAR(often.sigma(), once.sigma(), 1e-12);
}

}  // namespace
}  // namespace dcloc
