#include "core/versions/update_gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"
#include "core/versions/version_comparison.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

/// A town's map, and a pass that is held out of its updates.
class UpdateGateTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    SimulationOptions options;
    options.seed = 3;
    options.length_m = 300.0;
    const Drive map_drive = SimulatePass(options, Passes(options)[0]).value();
    drive_ = new Drive(SimulatePass(options, Passes(options)[1]).value());
    map_ = new EditableMap(
        ToEditable(*RadarMap::FromBytes(BuildMap(map_drive, {.name = "town"}).value()).value()));
  }
  static void TearDownTestSuite() {
    delete drive_;
    delete map_;
  }

  static UpdateEvaluation Evaluated(const EditableMap& before, const EditableMap& after,
                                    const std::vector<Eigen::Vector2d>& intermittent_local_m = {}) {
    std::vector<Scan> scans;
    for (const DriveScan& entry : drive_->scans) scans.push_back(entry.scan);
    const auto evaluation = EvaluateUpdate(before, after, drive_->rig, scans, intermittent_local_m);
    EXPECT_TRUE(evaluation.ok()) << evaluation.status();
    return evaluation.ok() ? *evaluation : UpdateEvaluation{};
  }

  /// The map without the landmarks whose number is `remainder` modulo `divisor`.
  static EditableMap Thinned(int divisor, int remainder) {
    EditableMap map = *map_;
    int number = 0;
    for (EditableKeyframe& keyframe : map.keyframes) {
      std::erase_if(keyframe.points,
                    [&](const MapPoint&) { return number++ % divisor == remainder; });
    }
    return map;
  }

  static inline Drive* drive_ = nullptr;
  static inline EditableMap* map_ = nullptr;
};

TEST_F(UpdateGateTest, NothingChangedIsNotBetter) {
  const UpdateEvaluation evaluation = Evaluated(*map_, *map_);
  EXPECT_FALSE(evaluation.is_better);
  EXPECT_THAT(evaluation.reason, HasSubstr("nothing has changed"));
  EXPECT_GT(evaluation.whole.old_version.tracking_share, 0.8);
  EXPECT_LT(evaluation.whole.old_version.error_m, 0.1);
}

TEST_F(UpdateGateTest, LandmarksThatWereMissingMakeItBetter) {
  const UpdateEvaluation evaluation = Evaluated(Thinned(4, 0), *map_);
  EXPECT_TRUE(evaluation.is_better) << evaluation.reason;
  EXPECT_GT(evaluation.whole.new_version.fit, evaluation.whole.old_version.fit);
  EXPECT_GT(evaluation.whole.added_count, 20U);
}

TEST_F(UpdateGateTest, LandmarksThatStandAndAreGoneMakeItWorse) {
  const UpdateEvaluation evaluation = Evaluated(*map_, Thinned(4, 0));
  EXPECT_FALSE(evaluation.is_better);
  EXPECT_THAT(evaluation.reason, HasSubstr("worse"));
}

TEST_F(UpdateGateTest, LandmarksThatLieElsewhereMakeItWorse) {
  EditableMap bent = *map_;
  int number = 0;
  for (EditableKeyframe& keyframe : bent.keyframes) {
    for (MapPoint& point : keyframe.points) {
      if (number++ % 2 == 0) point.y_m += 0.6F;
    }
  }
  const UpdateEvaluation evaluation = Evaluated(*map_, bent);
  EXPECT_FALSE(evaluation.is_better);
  EXPECT_THAT(evaluation.reason, HasSubstr("worse"));
}

TEST_F(UpdateGateTest, LandmarksThatAllLieToOneSideMakeItWorse) {
  EditableMap moved = Thinned(20, 0);
  for (EditableKeyframe& keyframe : moved.keyframes) {
    for (MapPoint& point : keyframe.points) point.x_m += 0.15F;
  }
  const UpdateEvaluation evaluation = Evaluated(Thinned(4, 0), moved);
  EXPECT_FALSE(evaluation.is_better);
  EXPECT_GT(evaluation.whole.new_version.offset_m, 0.08);
}

TEST_F(UpdateGateTest, WhatIsSaidToComeAndGoMustBeSeenLessThanWhatStays) {
  const EditableMap thinned = Thinned(10, 0);
  std::vector<Eigen::Vector2d> gone_m;
  for (const PlacedLandmark& landmark :
       CompareVersions(*map_, thinned, 0.5, PlaceSet({})).removed) {
    gone_m.push_back(landmark.position.position_m);
  }
  const UpdateEvaluation evaluation = Evaluated(*map_, thinned, gone_m);
  EXPECT_FALSE(evaluation.is_better);
  EXPECT_THAT(evaluation.reason, HasSubstr("of what comes and goes was seen"));
}

TEST_F(UpdateGateTest, WhatComesAndGoesMayGo) {
  EditableMap parked = *map_;
  std::vector<Eigen::Vector2d> parked_m;
  for (EditableKeyframe& keyframe : parked.keyframes) {
    if (keyframe.points.empty()) continue;
    MapPoint vehicle = keyframe.points.front();
    vehicle.x_m += 1.3F;
    vehicle.y_m -= 0.9F;
    keyframe.points.push_back(vehicle);
    parked_m.push_back((PoseOf(keyframe.record) * PositionOf(vehicle)).head<2>());
  }
  const UpdateEvaluation evaluation = Evaluated(parked, *map_, parked_m);
  EXPECT_TRUE(evaluation.is_better) << evaluation.reason;
  EXPECT_GT(evaluation.whole.intermittent_count, 12U);
  EXPECT_EQ(evaluation.whole.removed_count, 0U);
}

TEST_F(UpdateGateTest, LandmarksOfNothingMakeItNoBetter) {
  EditableMap haunted = *map_;
  for (EditableKeyframe& keyframe : haunted.keyframes) {
    const std::size_t count = keyframe.points.size();
    for (std::size_t i = 0; i < count; i += 3) {
      MapPoint ghost = keyframe.points[i];
      ghost.x_m += 1.3F;
      ghost.y_m -= 0.9F;
      keyframe.points.push_back(ghost);
    }
  }
  EXPECT_FALSE(Evaluated(*map_, haunted).is_better);
}

TEST_F(UpdateGateTest, RefusesAPassThatIsNotInTheMap) {
  SimulationOptions options;
  options.seed = 4;
  options.length_m = 200.0;
  const Drive other = SimulatePass(options, Passes(options)[1]).value();
  std::vector<Scan> scans;
  for (const DriveScan& entry : other.scans) scans.push_back(entry.scan);
  EXPECT_FALSE(EvaluateUpdate(*map_, Thinned(4, 0), other.rig, scans, {}).ok());
}

}  // namespace
}  // namespace dcloc
