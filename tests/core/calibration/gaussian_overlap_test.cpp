#include "core/calibration/gaussian_overlap.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

// One scatterer at (30, 8) as two radars see it; the second one's range is too long by `bias_m`.
FrameReturns OneScatterer(double bias_m) {
  const Eigen::Vector2d scatterer_m(30.0, 8.0);
  FrameReturns frame;
  for (const std::uint32_t radar : {0U, 1U}) {
    const Eigen::Vector2d radar_m(0.0, radar == 0 ? 0.0 : 20.0);
    frame.scans.push_back({.radar_m = radar_m,
                           .radar_velocity_mps = {10.0, 0.0},
                           .vehicle_m = radar_m,
                           .vehicle_velocity_mps = {10.0, 0.0},
                           .yaw_rate_radps = 0.0,
                           .planar = true,
                           .radar = radar,
                           .stand = 0});
    const Eigen::Vector2d sight_m = scatterer_m - radar_m;
    frame.returns.push_back(
        {.position_m = scatterer_m + (radar == 0 ? 0.0 : bias_m) * sight_m.normalized(),
         .covariance_m2 = 0.01 * Eigen::Matrix2d::Identity(),
         .range_m = sight_m.norm(),
         .cos_elevation = 1.0,
         .scan = radar});
  }
  return frame;
}

OverlapTerms TermsOf(const FrameReturns& frame, double min_range_m = 0.0) {
  constexpr auto kSize = Eigen::Index{2} * kCalibrationParameters;
  OverlapTerms terms(kSize);
  AddOverlap(frame, FindPairs(frame, 2.0, 10), Eigen::VectorXd::Zero(kSize),
             Eigen::VectorXd::Ones(kSize), {.min_range_m = min_range_m}, terms);
  return terms;
}

TEST(FindPairsTest, JoinsWhatIsNearAndSeenFromElsewhere) {
  FrameReturns frame = OneScatterer(0.2);
  EXPECT_EQ(FindPairs(frame, 2.0, 10).size(), 1U);
  EXPECT_TRUE(FindPairs(frame, 0.1, 10).empty());
  frame.scans[1].radar = 0;  // the same radar at the same stand
  EXPECT_TRUE(FindPairs(frame, 2.0, 10).empty());
  frame.scans[1].stand = 1;
  EXPECT_EQ(FindPairs(frame, 2.0, 10).size(), 1U);
}

TEST(OverlapTest, IsAtRestWhereReturnsCoincide) {
  const OverlapTerms terms = TermsOf(OneScatterer(0.0));
  EXPECT_LT(terms.gradient.norm(), 1e-12);
  EXPECT_GT(terms.hessian.norm(), 1.0);
}

// Freed alone, the second radar's range bias is what brings the two together.
TEST(OverlapTest, DrawsABiasedRangeBack) {
  constexpr auto kBias =
      kCalibrationParameters + static_cast<Eigen::Index>(CalibrationParameter::kRangeBias);
  const OverlapTerms terms = TermsOf(OneScatterer(0.2));
  EXPECT_NEAR(terms.gradient(kBias) / terms.hessian(kBias, kBias), 0.2, 0.005);
}

TEST(OverlapTest, LeavesOutWhatIsTooNear) {
  EXPECT_TRUE(TermsOf(OneScatterer(0.2), 50.0).hessian.isZero());
}

}  // namespace
}  // namespace dcloc
