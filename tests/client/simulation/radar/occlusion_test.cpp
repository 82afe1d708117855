#include "client/simulation/radar/occlusion.h"

#include <gtest/gtest.h>

namespace dcloc::simulation {
namespace {

/// 10 m ahead of the origin, 4 m wide and 2 m high.
Wall Ahead(double loss_db) {
  return {.begin_m = {10.0, -2.0}, .end_m = {10.0, 2.0}, .height_m = 2.0, .loss_db = loss_db};
}

TEST(OcclusionTest, AWallHidesWhatIsBehindItAndNothingElse) {
  Occlusion occlusion(Eigen::Vector3d(0.0, 0.0, 0.5));
  occlusion.Add(Ahead(kOpaqueDb));
  EXPECT_EQ(occlusion.LossDb({20.0, 0.0, 0.5}, 0.1), kOpaqueDb);
  EXPECT_EQ(occlusion.LossDb({9.9, 0.0, 0.5}, 0.1), 0.0);    // before it
  EXPECT_EQ(occlusion.LossDb({20.0, 4.1, 0.5}, 0.1), 0.0);   // beside it
  EXPECT_EQ(occlusion.LossDb({20.0, 0.0, 5.0}, 0.1), 0.0);   // over it
  EXPECT_EQ(occlusion.LossDb({-20.0, 0.0, 0.5}, 0.1), 0.0);  // on the other side
}

TEST(OcclusionTest, WhatATargetIsPartOfDoesNotHideIt) {
  Occlusion occlusion(Eigen::Vector3d(0.0, 0.0, 0.5));
  occlusion.Add(Ahead(kOpaqueDb));
  EXPECT_EQ(occlusion.LossDb({10.2, 0.0, 0.5}, 0.3), 0.0);
  EXPECT_EQ(occlusion.LossDb({10.2, 0.0, 0.5}, 0.1), kOpaqueDb);
}

TEST(OcclusionTest, LossesAddUpAlsoStraightBehind) {
  // Seen from here the walls lie where directions wrap, at 180 degrees.
  Occlusion occlusion(Eigen::Vector3d(30.0, 0.0, 0.5));
  occlusion.Add(Ahead(4.5));
  occlusion.Add({.begin_m = {5.0, 3.0}, .end_m = {5.0, -3.0}, .height_m = 2.0, .loss_db = 3.0});
  EXPECT_EQ(occlusion.LossDb({0.0, 0.05, 0.5}, 0.1), 7.5);
  EXPECT_EQ(occlusion.LossDb({0.0, -0.05, 0.5}, 0.1), 7.5);
  EXPECT_EQ(occlusion.LossDb({7.0, 0.0, 0.5}, 0.1), 4.5);
}

TEST(OcclusionTest, ACrossingIsAShareOfTheRay) {
  EXPECT_NEAR(CrossingShare({0.0, 0.0}, {20.0, 0.0}, Ahead(0.0)), 0.5, 1e-12);
  EXPECT_LT(CrossingShare({0.0, 0.0}, {5.0, 0.0}, Ahead(0.0)), 0.0);
  EXPECT_LT(CrossingShare({10.0, -9.0}, {10.0, 9.0}, Ahead(0.0)), 0.0);  // along it
}

}  // namespace
}  // namespace dcloc::simulation
