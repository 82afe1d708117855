#include "core/geometry/forgetting_mean.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

TEST(ForgettingMeanTest, BeginsAsTheMeanOfAll) {
  ForgettingMean values;
  for (const double value : {1.0, 2.0, 6.0}) values.Add(value, 0.98);
  EXPECT_EQ(values.count, 3);
  EXPECT_NEAR(values.mean, 3.0, 1e-12);
  EXPECT_NEAR(values.variance, (4.0 + 1.0 + 9.0) / 3.0, 1e-12);
}

TEST(ForgettingMeanTest, OldValuesFade) {
  ForgettingMean values;
  for (int i = 0; i < 1000; ++i) values.Add(5.0, 0.9);
  for (int i = 0; i < 200; ++i) values.Add(i % 2 == 0 ? 1.0 : 3.0, 0.9);
  EXPECT_NEAR(values.mean, 2.0, 0.1);
  EXPECT_NEAR(values.variance, 1.0, 0.1);
}

}  // namespace
}  // namespace dcloc
