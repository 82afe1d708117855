#include "core/passes/center_matching.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

std::vector<std::uint32_t> CentersOf(const std::vector<LandmarkPosition>& landmarks,
                                     const std::vector<LandmarkPosition>& centers) {
  std::vector<std::uint32_t> matched;
  for (const CenterMatch& match : MatchCenters(landmarks, centers)) matched.push_back(match.center);
  return matched;
}

LandmarkPosition At(double x_m, double y_m, double sigma_m = 0.08) {
  return {.position_m = {x_m, y_m},
          .covariance_m2 = sigma_m * sigma_m * Eigen::Matrix2d::Identity()};
}

TEST(MatchCentersTest, EachLandmarkGetsItsNearestCenter) {
  const std::vector<LandmarkPosition> landmarks = {At(0.0, 0.0), At(0.3, 0.0), At(9.0, 0.0)};
  const std::vector<LandmarkPosition> centers = {At(0.28, 0.0), At(0.05, 0.0)};
  EXPECT_EQ(CentersOf(landmarks, centers), (std::vector<std::uint32_t>{1, 0, kNoCenter}));
}

TEST(MatchCentersTest, LandmarksThatLieCloseMayHaveOneCenter) {
  const std::vector<LandmarkPosition> landmarks = {At(0.1, 0.0), At(0.0, 0.0)};
  const std::vector<LandmarkPosition> centers = {At(0.02, 0.0)};
  EXPECT_EQ(CentersOf(landmarks, centers), (std::vector<std::uint32_t>{0, 0}));
}

TEST(MatchCentersTest, HowFarTheyMayLieApartIsWhatIsKnownOfBoth) {
  EXPECT_EQ(CentersOf({{At(0.0, 0.0)}}, {{At(0.55, 0.0)}})[0], kNoCenter);
  EXPECT_EQ(CentersOf({{At(0.0, 0.0)}}, {{At(0.55, 0.0, 0.3)}})[0], 0U);
  EXPECT_EQ(CentersOf({{At(0.0, 0.0, 2.0)}}, {{At(0.85, 0.0, 2.0)}})[0], kNoCenter);
}

TEST(MatchCentersTest, AmongManyCentersOneLiesNearByChance) {
  const std::vector<LandmarkPosition> landmarks = {At(0.0, 0.0)};
  const std::vector<LandmarkPosition> alone = {At(0.0, 0.0)};
  const std::vector<LandmarkPosition> among_others = {At(0.0, 0.0), At(0.3, 0.0), At(-0.2, 0.2)};
  const double gate = CenterMatchingOptions{}.gate;
  EXPECT_NEAR(MatchCenters(landmarks, alone)[0].position_ratio, 0.5 * gate, 1e-9);
  EXPECT_LT(MatchCenters(landmarks, among_others)[0].position_ratio, 0.3 * gate);
  EXPECT_EQ(MatchCenters(landmarks, {})[0].position_ratio, 1.0);
}

}  // namespace
}  // namespace dcloc
