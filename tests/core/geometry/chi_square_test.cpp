#include "core/geometry/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace dcloc {
namespace {

// The probability of a larger value, in closed form.
double TailWith1Dof(double x) { return std::erfc(std::sqrt(0.5 * x)); }
double TailWith2Dof(double x) { return std::exp(-0.5 * x); }
double TailWith3Dof(double x) {
  return TailWith1Dof(x) + std::sqrt(2.0 * x / std::numbers::pi) * std::exp(-0.5 * x);
}
double TailWith6Dof(double x) { return std::exp(-0.5 * x) * (1.0 + 0.5 * x + 0.125 * x * x); }

TEST(ChiSquareTest, QuantilesAreExceededAsOftenAsTheirNamesSay) {
  EXPECT_NEAR(TailWith3Dof(kChiSquare95With3Dof), 0.05, 1e-5);
  EXPECT_NEAR(TailWith6Dof(kChiSquare95With6Dof), 0.05, 1e-5);
  EXPECT_NEAR(TailWith1Dof(kChiSquare999With1Dof), 0.001, 2e-5);
  EXPECT_NEAR(TailWith2Dof(kChiSquare999With2Dof), 0.001, 1e-5);
  EXPECT_NEAR(TailWith3Dof(kChiSquare999With3Dof), 0.001, 1e-5);
}

}  // namespace
}  // namespace dcloc
