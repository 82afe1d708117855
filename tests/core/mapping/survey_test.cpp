#include "core/mapping/survey.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/mapping/drive_tracker.h"
#include "tests/core/mapping/ring_road.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

struct RingDrive {
  DriveTrack track;
  std::vector<Pose2> T_truth_nodes;
};

RingDrive DriveRing(const SyntheticWorld& world, const char* name, double begin_m, double length_m,
                    double speed_mps, unsigned seed) {
  DriveTracker tracker(name, FrontRadar(), {});
  std::vector<std::pair<Stamp, Pose2>> truth;
  for (const auto& [scan, T_map_vehicle] : ScansOnRing(world, begin_m, length_m, speed_mps, seed)) {
    const absl::Status added = tracker.Add(scan);
    EXPECT_TRUE(added.ok()) << added;
    truth.emplace_back(scan.stamp, Flatten(T_map_vehicle));
  }
  RingDrive drive{.track = tracker.Finish(), .T_truth_nodes = {}};
  for (const SurveyNode& node : drive.track.nodes) {
    for (const auto& [stamp, T] : truth) {
      if (stamp == node.stamp) drive.T_truth_nodes.push_back(T);
    }
  }
  return drive;
}

// The largest distance from the truth, the first node of the first drive in the map at its place.
double MaxError(const Survey& survey, const std::vector<RingDrive>& drives,
                std::vector<Pose2> SurveyedDrive::*poses) {
  const Pose2 T_truth_map = drives[0].T_truth_nodes[0] * (survey.drives[0].*poses)[0].Inverse();
  double error_m = 0.0;
  for (std::size_t d = 0; d < drives.size(); ++d) {
    if (!survey.drives[d].is_in_map) continue;
    for (std::size_t i = 0; i < drives[d].T_truth_nodes.size(); ++i) {
      const Pose2 T = T_truth_map * (survey.drives[d].*poses)[i];
      error_m =
          std::max(error_m, (T.translation_m - drives[d].T_truth_nodes[i].translation_m).norm());
    }
  }
  return error_m;
}

bool GoOn(const char* /*stage*/, double /*share*/) { return true; }

std::vector<DriveTrack> TracksOf(const std::vector<RingDrive>& drives) {
  std::vector<DriveTrack> tracks;
  tracks.reserve(drives.size());
  for (const RingDrive& drive : drives) tracks.push_back(drive.track);
  return tracks;
}

TEST(SurveyTest, ClosesTheRing) {
  const SyntheticWorld world = RingRoad(1);
  const std::vector<RingDrive> drives = {DriveRing(world, "lap", 0.0, 750.0, 12.0, 1)};
  const auto survey = SurveyDrives(TracksOf(drives), {}, {}, GoOn);
  ASSERT_TRUE(survey.ok()) << survey.status();
  EXPECT_TRUE(survey->drives[0].is_in_map);
  EXPECT_GT(survey->loops.size(), 5U);
  EXPECT_LT(MaxError(*survey, drives, &SurveyedDrive::T_map_nodes), 0.8);
  EXPECT_LT(MaxError(*survey, drives, &SurveyedDrive::T_map_nodes),
            MaxError(*survey, drives, &SurveyedDrive::T_start_nodes));
}

TEST(SurveyTest, JoinsDrivesThatOverlap) {
  const SyntheticWorld world = RingRoad(2);
  const std::vector<RingDrive> drives = {DriveRing(world, "a", 0.0, 620.0, 12.0, 2),
                                         DriveRing(world, "b", 300.0, 250.0, 15.0, 3)};
  const auto survey = SurveyDrives(TracksOf(drives), {}, {}, GoOn);
  ASSERT_TRUE(survey.ok()) << survey.status();
  EXPECT_TRUE(survey->drives[1].is_in_map) << survey->drives[1].reason;
  EXPECT_LT(MaxError(*survey, drives, &SurveyedDrive::T_map_nodes), 1.0);
}

TEST(SurveyTest, LeavesOutADriveOfAnotherTownAndOneThatStands) {
  const std::vector<RingDrive> drives = {DriveRing(RingRoad(3), "here", 0.0, 400.0, 12.0, 4),
                                         DriveRing(RingRoad(4), "elsewhere", 0.0, 200.0, 12.0, 5),
                                         DriveRing(RingRoad(3), "standing", 0.0, 5.0, 1.0, 6)};
  const auto survey = SurveyDrives(TracksOf(drives), {}, {}, GoOn);
  ASSERT_TRUE(survey.ok()) << survey.status();
  EXPECT_TRUE(survey->drives[0].is_in_map);
  EXPECT_FALSE(survey->drives[1].is_in_map);
  EXPECT_THAT(survey->drives[1].reason, HasSubstr("shares no ground"));
  EXPECT_FALSE(survey->drives[2].is_in_map);
  EXPECT_THAT(survey->drives[2].reason, HasSubstr("it moved"));
}

TEST(SurveyTest, FixesPlaceTheMap) {
  const SyntheticWorld world = RingRoad(5);
  const std::vector<RingDrive> drives = {DriveRing(world, "a", 0.0, 300.0, 12.0, 7)};
  std::mt19937 random(8);
  std::normal_distribution<double> noise_m(0.0, 0.5);
  std::vector<SurveyFix> fixes;
  for (std::size_t i = 1; i < drives[0].T_truth_nodes.size(); ++i) {
    const Eigen::Vector2d p = drives[0].T_truth_nodes[i].translation_m;
    fixes.push_back({.drive = 0,
                     .stamp = drives[0].track.nodes[i].stamp,
                     .p_map = p + Eigen::Vector2d(noise_m(random), noise_m(random)),
                     .sigma_m = 0.5});
    if (i % 8 == 0) fixes.back().p_map.y() += 30.0;
  }
  const auto survey = SurveyDrives(TracksOf(drives), fixes, {}, GoOn);
  ASSERT_TRUE(survey.ok()) << survey.status();
  EXPECT_EQ(survey->fix_count, fixes.size());
  EXPECT_GE(survey->accepted_fix_count, fixes.size() * 3 / 4);
  EXPECT_LT(survey->accepted_fix_count, fixes.size());
  for (std::size_t i = 0; i < drives[0].T_truth_nodes.size(); ++i) {
    EXPECT_LT(
        (survey->drives[0].T_map_nodes[i].translation_m - drives[0].T_truth_nodes[i].translation_m)
            .norm(),
        1.0);
  }
}

TEST(SurveyTest, SaysWhyNothingIsLeftAndStopsWhenTold) {
  const std::vector<RingDrive> standing = {DriveRing(RingRoad(6), "still", 0.0, 5.0, 1.0, 9)};
  const auto none = SurveyDrives(TracksOf(standing), {}, {}, GoOn);
  EXPECT_EQ(none.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(none.status().message()), HasSubstr("still: it moved"));

  const std::vector<RingDrive> drives = {DriveRing(RingRoad(6), "a", 0.0, 100.0, 12.0, 10)};
  const auto stopped =
      SurveyDrives(TracksOf(drives), {}, {}, [](const char*, double) { return false; });
  EXPECT_EQ(stopped.status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace dcloc
