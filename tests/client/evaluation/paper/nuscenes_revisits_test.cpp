#include "client/evaluation/paper/nuscenes_revisits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/client/evaluation/paper/made_outcomes.h"
#include "tests/client/fixtures/field_cases.h"

namespace dcloc::paper {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

// Key frames every half second from `begin_s` on, along x from `x_m` in steps of `step_m`.
SceneTrack Straight(const std::string& name, double begin_s, double x_m, double step_m, int count,
                    double y_m = 0.0, double yaw_rad = 0.0) {
  SceneTrack track{.scene = name, .location = "town", .vehicle = "car"};
  for (int i = 0; i < count; ++i) {
    track.key_frames.push_back(
        {At(begin_s + 0.5 * i),
         Embed(Pose2{.translation_m = {x_m + step_m * i, y_m}, .yaw_rad = yaw_rad})});
  }
  return track;
}

std::vector<Revisit> RevisitsOf(const std::vector<SceneTrack>& tracks) {
  return *FindRevisits(tracks);
}

TEST(FindRevisits, PairsALaterSceneWithAnEarlierOne) {
  const std::vector<SceneTrack> tracks = {Straight("early", 0.0, 0.0, 2.0, 50),
                                          Straight("late", 1000.0, 40.0, 3.0, 10, 3.0, 0.3)};
  const auto revisits = RevisitsOf(tracks);
  ASSERT_THAT(revisits, SizeIs(1));
  EXPECT_EQ(revisits[0].map_scene, "early");
  EXPECT_EQ(revisits[0].live_scene, "late");
  EXPECT_EQ(revisits[0].begin, At(1000.0));
  EXPECT_EQ(revisits[0].end, At(1004.5));
}

TEST(FindRevisits, WantsTheSamePlaceHeadingAndLocation) {
  const SceneTrack early = Straight("early", 0.0, 0.0, 1.0, 50);
  EXPECT_THAT(RevisitsOf({early, Straight("a", 99.0, 0.0, 1.0, 9, 4.9)}), SizeIs(1));
  EXPECT_THAT(RevisitsOf({early, Straight("a", 99.0, 0.0, 1.0, 9, 5.1)}), IsEmpty());
  EXPECT_THAT(RevisitsOf({early, Straight("a", 99.0, 0.0, 1.0, 9, 0.0, 0.49)}), SizeIs(1));
  EXPECT_THAT(RevisitsOf({early, Straight("a", 99.0, 0.0, 1.0, 9, 0.0, -0.51)}), IsEmpty());
  EXPECT_THAT(RevisitsOf({early, Straight("a", 99.0, 40.0, -1.0, 9, 0.0, M_PI)}), IsEmpty());
  SceneTrack elsewhere = Straight("a", 99.0, 0.0, 1.0, 9);
  elsewhere.location = "harbour";
  EXPECT_THAT(RevisitsOf({early, elsewhere}), IsEmpty());
}

TEST(FindRevisits, TakesTheNearestOfAllEarlierScenes) {
  const std::vector<SceneTrack> tracks = {Straight("far", 0.0, 0.0, 1.0, 50, 4.0),
                                          Straight("near", 100.0, 0.0, 1.0, 50, 1.0),
                                          Straight("late", 200.0, 0.0, 1.0, 20, 0.0)};
  const auto revisits = RevisitsOf(tracks);
  ASSERT_THAT(revisits, SizeIs(2));
  EXPECT_EQ(revisits[0].live_scene, "near");
  EXPECT_EQ(revisits[0].map_scene, "far");
  EXPECT_EQ(revisits[1].live_scene, "late");
  EXPECT_EQ(revisits[1].map_scene, "near");
}

TEST(FindRevisits, LeavesOutRunsOfFewKeyFrames) {
  // The late scene comes from 4 m beyond reach and has but two, then three, key frames within.
  const SceneTrack early = Straight("early", 0.0, 0.0, 1.0, 20);
  EXPECT_THAT(RevisitsOf({early, Straight("a", 99.0, 21.5, 2.0, 9)}), IsEmpty());
  const auto revisits = RevisitsOf({early, Straight("a", 99.0, 19.5, 2.0, 9)});
  ASSERT_THAT(revisits, SizeIs(1));
  EXPECT_EQ(revisits[0].end, At(100.0));
}

TEST(FindRevisits, BeginsAnewWhereTheMapSceneChanges) {
  std::vector<SceneTrack> tracks = {Straight("a", 0.0, 0.0, 1.0, 20),
                                    Straight("b", 100.0, 30.0, 1.0, 20),
                                    Straight("late", 200.0, 0.0, 1.0, 50)};
  const auto revisits = RevisitsOf(tracks);
  ASSERT_THAT(revisits, SizeIs(2));
  EXPECT_EQ(revisits[0].map_scene, "a");
  EXPECT_EQ(revisits[0].end, At(200.0 + 0.5 * 24));  // 24 m: 5 m beyond the end of a
  EXPECT_EQ(revisits[1].map_scene, "b");
  EXPECT_EQ(revisits[1].begin, At(200.0 + 0.5 * 25));
}

TEST(RevisitOptionsTest, EachFieldIsValidated) {
  [[maybe_unused]] const auto& [max_distance_m, max_turn_rad, min_pairs] = RevisitOptions{};
  ExpectEachFieldIsValidated<RevisitOptions>(
      {}, {{"max_distance_m", [](auto& o, double v) { o.max_distance_m = v; }, {}},
           {"max_turn_rad",
            [](auto& o, double v) { o.max_turn_rad = v; },
            {.zero = "the very same heading"}},
           {"min_pairs",
            [](auto& o, double v) { o.min_pairs = static_cast<int>(v); },
            {.nan = kIsAnInteger}}});
}

}  // namespace
}  // namespace dcloc::paper
