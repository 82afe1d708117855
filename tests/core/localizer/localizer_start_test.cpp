#include <gtest/gtest.h>

#include <optional>

#include "core/localizer/localizer.h"
#include "tests/core/localizer/on_a_road.h"
#include "tests/core/localizer/synthetic_world.h"

namespace dcloc {
namespace {

class LocalizerStartTest : public OnARoad {};

TEST_F(LocalizerStartTest, StartsFromAPriorThatIsOff) {
  const Pose3 off = Embed(Pose2{.translation_m = {0.8, -0.6}, .yaw_rad = 2.0 * kDegree});
  const auto answers = LocalizeDrive(
      MakeLocalizer(map_, FrontRadar(), PriorAt(Start() * off, 1.0, 2.0 * kDegree)), drive_);
  const Errors errors = ErrorsOf(answers);
  EXPECT_LT(errors.first_tracking, 30);
  ASSERT_GT(errors.first_tracking, 0);
  EXPECT_LT(errors.mean_m, 0.1);
  EXPECT_LT(answers[60].position_error_m(), 0.2);
  EXPECT_LT(answers[60].yaw_error_rad(), 0.5 * kDegree);
}

TEST_F(LocalizerStartTest, StartsFromAnExactPrior) {
  const auto answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.0, 0.0)), drive_);
  const Errors errors = ErrorsOf(answers);
  EXPECT_GT(errors.tracking_count, 80);
  EXPECT_LT(errors.mean_m, 0.08);
}

TEST_F(LocalizerStartTest, FindsThePlaceWithoutAPrior) {
  // From some way down the road on.
  const std::vector<TrueScan> drive(drive_.begin() + 40, drive_.end());
  const auto answers = LocalizeDrive(MakeLocalizer(map_, FrontRadar(), std::nullopt), drive);
  EXPECT_EQ(answers[0].localization.state, LocalizationState::kInitializing);
  EXPECT_GT(answers[0].localization.covariance(0, 0), 1e6) << "knows nothing, and says so";
  const Errors errors = ErrorsOf(answers);
  ASSERT_GE(errors.first_tracking, 0) << "never tracked";
  EXPECT_LT(errors.first_tracking, 80);
  EXPECT_LT(errors.mean_m, 0.1);
  EXPECT_LT(errors.max_m, 0.4);
}

TEST_F(LocalizerStartTest, RadarsOf50HzStartToo) {
  const auto drive = DriveRoad(SyntheticWorld(), FrontRadar(), kLiveSpeed_mps, 2, 20);
  for (const bool has_prior : {true, false}) {
    const auto prior =
        has_prior ? std::optional(PriorAt(Start(), 1.0, 2.0 * kDegree)) : std::nullopt;
    const Errors errors = ErrorsOf(LocalizeDrive(MakeLocalizer(map_, FrontRadar(), prior), drive));
    ASSERT_GE(errors.first_tracking, 0) << "never tracked";
    EXPECT_LT(errors.first_tracking, 250);
    EXPECT_LT(errors.mean_m, 0.1);
  }
}

TEST_F(LocalizerStartTest, ElsewhereItDoesNotFindItself) {
  // Another world: no answer may claim to track in this map.
  SyntheticWorld other;
  std::mt19937 random(99);
  std::uniform_real_distribution<double> place_m(-40.0, 200.0);
  for (Eigen::Vector3d& scatterer_m : other.scatterers_m) {
    scatterer_m = {place_m(random), place_m(random), 0.0};
  }
  auto drive = DriveRoad(other, FrontRadar(), kLiveSpeed_mps, 3);
  drive.resize(70);  // each of its searches goes over the whole map
  const auto answers = LocalizeDrive(MakeLocalizer(map_, FrontRadar(), std::nullopt), drive);
  EXPECT_EQ(ErrorsOf(answers).tracking_count, 0);
}

TEST_F(LocalizerStartTest, APriorWithoutAHeadingIsSearchedAround) {
  InitialPose prior = PriorAt(Start(), 3.0, 1.8);
  prior.T_map_vehicle.rotation = Eigen::AngleAxisd(2.5, Eigen::Vector3d::UnitZ());
  Localizer localizer = MakeLocalizer(map_, FrontRadar(), prior);
  EXPECT_FALSE(localizer.has_pose());
  const auto answers = LocalizeDrive(std::move(localizer), drive_);
  EXPECT_EQ(answers[5].localization.state, LocalizationState::kInitializing);
  EXPECT_TRUE(answers.back().tracking());
  EXPECT_LT(answers.back().position_error_m(), 0.25);
}

// They look alike wherever one stands between them.
std::vector<TrueAnswer> StartAmongPosts(const LocalizerOptions& options) {
  constexpr double kSpacing_m = 3.0;
  const SyntheticWorld world = SyntheticWorld::Posts(kSpacing_m);
  const auto map = MapOfDrive(DriveRoad(world, FrontRadar(), kMapSpeed_mps, 1), FrontRadar());
  auto drive = DriveRoad(world, FrontRadar(), kLiveSpeed_mps, 2);
  drive.resize(40);
  const Pose3 off = Embed(Pose2{.translation_m = {kSpacing_m, 0.0}, .yaw_rad = 2.0 * kDegree});
  const InitialPose prior = PriorAt(drive.front().T_map_vehicle * off, 2.1, 2.0 * kDegree);
  return LocalizeDrive(MakeLocalizer(map, FrontRadar(), prior, options), drive);
}

TEST_F(LocalizerStartTest, PlacesThatLookAlikeWithinAWidePriorAreNotClaimed) {
  LocalizerOptions credulous;
  credulous.matcher.wide_sigma_m = 100.0;
  credulous.verify_prior = false;
  ASSERT_GT(ErrorsOf(StartAmongPosts(credulous)).max_m, 2.0) << "or the posts do not mislead";
  EXPECT_EQ(ErrorsOf(StartAmongPosts({})).tracking_count, 0);
}

TEST_F(LocalizerStartTest, AWidePriorIsClaimedAtOnceWhereOnePlaceStandsOut) {
  const Pose3 off = Embed(Pose2{.translation_m = {2.5, -1.5}, .yaw_rad = 4.0 * kDegree});
  const auto answers = LocalizeDrive(
      MakeLocalizer(map_, FrontRadar(), PriorAt(Start() * off, 2.1, 5.0 * kDegree)), drive_);
  const Errors errors = ErrorsOf(answers);
  EXPECT_LT(errors.first_tracking, 20);
  EXPECT_GT(errors.tracking_count, 80);
  EXPECT_LT(errors.max_m, 0.4);
}

TEST_F(LocalizerStartTest, AStartOutsideOfTheMapWaitsUntilItEntersIt) {
  // Two kilometres off, and so far off that nothing can be computed there.
  for (const double far_m : {2000.0, 1e9}) {
    Pose3 away = Start();
    away.translation_m.x() -= far_m;
    Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(away, 0.2, 0.01));
    for (std::size_t i = 0; i < 30; ++i) {
      const auto answer = localizer.Localize(drive_[i].scan);
      ASSERT_TRUE(answer.ok());
      EXPECT_EQ(answer->state, LocalizationState::kInitializing);
      EXPECT_TRUE(answer->T_map_vehicle.translation_m.allFinite());
      EXPECT_TRUE(IsCovariance(answer->covariance));
    }
  }
}

}  // namespace
}  // namespace dcloc
