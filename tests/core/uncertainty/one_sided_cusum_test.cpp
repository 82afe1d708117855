#include "core/uncertainty/one_sided_cusum.h"

#include <gtest/gtest.h>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

constexpr OneSidedCusumOptions kOptions = {.drift = 1.0, .max = 3.0, .limit = 4.0};

TEST(OneSidedCusumOptionsTest, EachFieldIsBounded) {
  ExpectEachFieldIsBounded<OneSidedCusumOptions>();
}

TEST(OneSidedCusumTest, DeviationsAddUpAboveTheDrift) {
  OneSidedCusum sum;
  sum.Add(3.0, kOptions);
  EXPECT_FALSE(sum.is_exceeded());
  sum.Add(3.0, kOptions);
  EXPECT_TRUE(sum.is_exceeded());
}

TEST(OneSidedCusumTest, OneLargeDeviationDecidesNothing) {
  OneSidedCusum sum;
  sum.Add(1e9, kOptions);
  EXPECT_FALSE(sum.is_exceeded());
}

TEST(OneSidedCusumTest, UsualDeviationsAreForgotten) {
  OneSidedCusum sum;
  for (int i = 0; i < 1000; ++i) sum.Add(i % 2 == 0 ? 2.0 : -1.0, kOptions);
  EXPECT_FALSE(sum.is_exceeded());
}

TEST(OneSidedCusumTest, ItStaysExceededUntilHalfOfTheLimit) {
  OneSidedCusum sum;
  for (int i = 0; i < 1000; ++i) sum.Add(3.0, kOptions);
  sum.Add(0.0, kOptions);
  EXPECT_TRUE(sum.is_exceeded());
  sum.Add(0.0, kOptions);
  EXPECT_FALSE(sum.is_exceeded());
}

}  // namespace
}  // namespace dcloc
