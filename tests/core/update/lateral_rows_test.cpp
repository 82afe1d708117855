#include "core/update/lateral_rows.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dcloc {
namespace {

/// A bend of 100 m radius to the left, a keyframe each 10 m.
std::vector<Pose3> Bend() {
  std::vector<Pose3> keyframes;
  for (int k = 0; k < 16; ++k) {
    const double angle_rad = 0.1 * k;
    keyframes.push_back(
        {.translation_m = {100.0 * std::sin(angle_rad), 100.0 * (1.0 - std::cos(angle_rad)), 0.0},
         .rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()))});
  }
  return keyframes;
}

/// Places beside each keyframe of the bend, `offset_m` to the left.
void AddRow(double offset_m, std::vector<Eigen::Vector2d>& places_m) {
  for (const Pose3& T_local_keyframe : Bend()) {
    places_m.push_back((T_local_keyframe * Eigen::Vector3d(2.0, offset_m, 0.0)).head<2>());
  }
}

TEST(LateralRowsTest, WhatIsExpectedOfARowIsWhatMostOfItDoes) {
  std::vector<Eigen::Vector2d> places_m;
  AddRow(5.0, places_m);
  AddRow(8.0, places_m);
  std::vector<RowVote> votes(16, {.intermittent = 0.9});
  votes.resize(32, {.lasts = 0.9});
  const std::vector<double> shares = LateralRows(Bend(), places_m).IntermittentShares(votes);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_GT(shares[i], 0.75) << i;
    EXPECT_LT(shares[16 + i], 0.1) << i;
  }
}

TEST(LateralRowsTest, APlaceSaysNothingOfItself) {
  std::vector<Eigen::Vector2d> places_m;
  AddRow(5.0, places_m);
  const LateralRows rows(Bend(), places_m);
  std::vector<RowVote> votes(16, {.lasts = 1.0});
  const double before = rows.IntermittentShares(votes)[7];
  votes[7] = {.intermittent = 1.0};
  EXPECT_NEAR(rows.IntermittentShares(votes)[7], before, 1e-12);
}

TEST(LateralRowsTest, OneWitnessAloneIsNotBelieved) {
  std::vector<Eigen::Vector2d> places_m;
  AddRow(5.0, places_m);
  const LateralRows rows(Bend(), places_m);
  std::vector<RowVote> votes(16, {.intermittent = 0.9, .only_witness = 2});
  EXPECT_LT(rows.IntermittentShares(votes)[7], 0.1);
  for (std::size_t i = 0; i < 16; i += 2) votes[i].only_witness = 0;
  EXPECT_GT(rows.IntermittentShares(votes)[7], 0.5);
}

TEST(LateralRowsTest, WithoutVotesLittleComesAndGoes) {
  const LateralRows rows(Bend(), std::vector<Eigen::Vector2d>{{0.0, 5.0}});
  EXPECT_NEAR(rows.IntermittentShares(std::vector<RowVote>(1))[0], 0.05, 1e-12);
}

}  // namespace
}  // namespace dcloc
