#include "core/registration/likelihood_field.h"

#include <gtest/gtest.h>

#include <vector>

namespace dcloc {
namespace {

const std::vector<Eigen::Vector2d> kLandmark_m = {{10.5, 20.5}};

LikelihoodField FieldOf(std::span<const Eigen::Vector2d> landmarks_m) {
  return {landmarks_m, 1.0, Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(40.0, 40.0)};
}

double ScoreAt(const LikelihoodField& field, const Pose2& T_local_vehicle) {
  const std::vector<Eigen::Vector2f> points = {{3.0F, 0.0F}};
  return field.Score(points, T_local_vehicle);
}

TEST(LikelihoodFieldTest, IsHighestAtALandmarkAndFallsWithTheDistance) {
  const LikelihoodField field = FieldOf(kLandmark_m);
  double before = 1.1;
  for (const double aside_m : {0.0, 1.0, 2.0, 3.0}) {
    const double score = ScoreAt(field, {.translation_m = {7.5, 20.5 + aside_m}, .yaw_rad = 0.0});
    EXPECT_LT(score, before) << aside_m;
    before = score;
  }
  EXPECT_NEAR(ScoreAt(field, {.translation_m = {7.5, 20.5}, .yaw_rad = 0.0}), 1.0, 1e-6);
  EXPECT_EQ(ScoreAt(field, {.translation_m = {7.5, 30.5}, .yaw_rad = 0.0}), 0.0);
}

TEST(LikelihoodFieldTest, PointsAreTurnedWithTheVehicle) {
  const LikelihoodField field = FieldOf(kLandmark_m);
  EXPECT_NEAR(ScoreAt(field, {.translation_m = {10.5, 17.5}, .yaw_rad = 1.5707963}), 1.0, 1e-6);
  EXPECT_EQ(ScoreAt(field, {.translation_m = {10.5, 17.5}, .yaw_rad = -1.5707963}), 0.0);
}

TEST(LikelihoodFieldTest, OutsideOfTheFieldNothingIsLikely) {
  const LikelihoodField field = FieldOf(kLandmark_m);
  EXPECT_EQ(ScoreAt(field, {.translation_m = {-1e3, 1e3}, .yaw_rad = 0.0}), 0.0);
  EXPECT_EQ(ScoreAt(field, {.translation_m = {1e9, 0.0}, .yaw_rad = 0.0}), 0.0);
}

TEST(LikelihoodFieldTest, LandmarksOutsideOfTheBoxAreLeftOut) {
  const std::vector<Eigen::Vector2d> outside_m = {{-50.0, 3.0}, {3.0, 500.0}};
  const LikelihoodField field = FieldOf(outside_m);
  for (int row = 0; row < field.rows(); ++row) {
    for (int column = 0; column < field.columns(); ++column) {
      ASSERT_EQ(*field.At({column, row}), 0) << column << ", " << row;
    }
  }
}

TEST(LikelihoodFieldTest, OfNothingThereIsNone) {
  EXPECT_TRUE(LikelihoodField().empty());
  EXPECT_EQ(ScoreAt(LikelihoodField(), {}), 0.0);
  EXPECT_EQ(FieldOf(kLandmark_m).Score({}, {}), 0.0);
}

}  // namespace
}  // namespace dcloc
