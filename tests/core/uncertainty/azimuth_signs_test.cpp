#include "core/uncertainty/azimuth_signs.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

constexpr std::size_t kComparedPoints = 50;

// How many scans that fit so it takes until the sign changes; at most `limit`.
int ScansUntilChanged(AzimuthSigns& signs, double fit, double mirrored_fit, int limit = 1000) {
  int count = 1;
  while (!signs.OnFits(0, kComparedPoints, fit, mirrored_fit) && count < limit) ++count;
  return count;
}

TEST(AzimuthSignOptionsTest, EachFieldIsBounded) { ExpectEachFieldIsBounded<AzimuthSignOptions>(); }

TEST(AzimuthSignsTest, AFewScansWhoseMirrorImageFitsShowTheSign) {
  AzimuthSigns signs(2, {});
  EXPECT_FALSE(signs.IsMirrored(0));
  const int count = ScansUntilChanged(signs, 0.15, 0.35);
  EXPECT_GT(count, 1);
  EXPECT_LE(count, 5);
  EXPECT_TRUE(signs.IsMirrored(0));
  EXPECT_FALSE(signs.IsMirrored(1));
}

TEST(AzimuthSignsTest, EachThirdScanIsComparedUntilOneSpeaksForTheOtherSign) {
  AzimuthSigns signs(2, {});
  for (const bool is_due : {false, false, true, false, false, true}) {
    EXPECT_EQ(signs.IsDue(0), is_due);
  }
  signs.OnFits(0, kComparedPoints, 0.15, 0.35);
  for (int scan = 0; scan < 4; ++scan) EXPECT_TRUE(signs.IsDue(0));
  EXPECT_FALSE(signs.IsDue(1));
}

TEST(AzimuthSignsTest, EachScanIsComparedWhileASignIsUnproven) {
  AzimuthSigns signs(1, {});
  ScansUntilChanged(signs, 0.15, 0.35);
  for (int scan = 0; scan < 4; ++scan) EXPECT_TRUE(signs.IsDue(0));
  signs.OnConfirmed();
  EXPECT_FALSE(signs.IsDue(0));
}

TEST(AzimuthSignsTest, WhereNothingFitsEitherSignIsTriedInTurn) {
  AzimuthSigns signs(2, {});
  ScansUntilChanged(signs, 0.15, 0.35);
  EXPECT_FALSE(signs.TryOther(1));
  EXPECT_TRUE(signs.TryOther(0));
  EXPECT_FALSE(signs.IsMirrored(0));
  EXPECT_TRUE(signs.TryOther(0));
  EXPECT_TRUE(signs.IsMirrored(0));
  EXPECT_FALSE(signs.IsMirrored(1));
}

TEST(AzimuthSignsTest, ASignWithWhichThePoseWasConfirmedStays) {
  AzimuthSigns signs(1, {});
  ScansUntilChanged(signs, 0.15, 0.35);
  signs.OnConfirmed();
  EXPECT_FALSE(signs.TryOther(0));
  EXPECT_TRUE(signs.IsMirrored(0));
}

TEST(AzimuthSignsTest, ASignThatChangesAgainIsStillUnproven) {
  AzimuthSigns signs(1, {});
  ScansUntilChanged(signs, 0.15, 0.35);
  EXPECT_TRUE(signs.TryOther(0));
  ScansUntilChanged(signs, 0.15, 0.35);
  EXPECT_TRUE(signs.IsMirrored(0));
  EXPECT_TRUE(signs.TryOther(0));
  EXPECT_FALSE(signs.IsMirrored(0));
}

TEST(AzimuthSignsTest, ASignThatIsTakenWronglyIsTakenBack) {
  AzimuthSigns signs(1, {});
  ScansUntilChanged(signs, 0.15, 0.35);
  EXPECT_LE(ScansUntilChanged(signs, 0.15, 0.35), 5);
  EXPECT_FALSE(signs.IsMirrored(0));
}

TEST(AzimuthSignsTest, WhereBothFitAlikeTheSignStays) {
  AzimuthSigns signs(1, {});
  EXPECT_EQ(ScansUntilChanged(signs, 0.30, 0.33), 1000);
  EXPECT_FALSE(signs.IsMirrored(0));
}

// At a wrong pose neither lies in the map, though one may do so a little more than the other.
TEST(AzimuthSignsTest, AMirrorImageThatFitsAsLittleShowsNothing) {
  AzimuthSigns signs(1, {});
  EXPECT_EQ(ScansUntilChanged(signs, 0.05, 0.25), 1000);
  EXPECT_FALSE(signs.IsMirrored(0));
}

TEST(AzimuthSignsTest, ScansOfAnotherPlaceDoNotCount) {
  AzimuthSigns signs(1, {});
  const int needed = ScansUntilChanged(signs, 0.25, 0.45);
  signs.Reset();
  for (int i = 0; i + 1 < needed; ++i) signs.OnFits(0, kComparedPoints, 0.25, 0.45);
  signs.Reset();
  EXPECT_EQ(ScansUntilChanged(signs, 0.25, 0.45), needed);
}

TEST(AzimuthSignsTest, ComparedPosesLieAroundThePoseAndTurnedRound) {
  const AzimuthSigns signs(1, {.rival_step_m = 1.0, .max_beside_m = 1.0, .max_ahead_m = 2.0});
  std::vector<Eigen::Vector3d> poses;  // ahead, beside, turned
  for (const Pose2& pose : signs.T_vehicle_poses()) {
    poses.emplace_back(pose.translation_m.x(), pose.translation_m.y(), pose.yaw_rad);
  }
  constexpr double kRound = std::numbers::pi;
  EXPECT_EQ(poses, (std::vector<Eigen::Vector3d>{{0, 0, 0},
                                                 {0, 1, 0},
                                                 {0, -1, 0},
                                                 {0, 0, kRound},
                                                 {0, 1, kRound},
                                                 {0, -1, kRound},
                                                 {1, 0, 0},
                                                 {-1, 0, 0},
                                                 {2, 0, 0},
                                                 {-2, 0, 0}}));
}

}  // namespace
}  // namespace dcloc
