#include "core/update/street_by_street.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"

namespace dcloc {
namespace {

bool HasPointsOf(const EditableKeyframe& a, const EditableKeyframe& b) {
  return a.points.size() == b.points.size() &&
         std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(MapPoint)) == 0;
}

/// Without every fourth landmark.
EditableMap Thinned(EditableMap map) {
  int number = 0;
  for (EditableKeyframe& keyframe : map.keyframes) {
    std::erase_if(keyframe.points, [&](const MapPoint&) { return number++ % 4 == 0; });
  }
  return map;
}

TEST(StreetByStreetTest, AStreetThatIsWorseStaysAsItWasAndTheOthersAreTaken) {
  SimulationOptions options;
  options.seed = 3;
  options.length_m = 400.0;
  const Drive map_drive = SimulatePass(options, Passes(options)[0]).value();
  const Drive held_out = SimulatePass(options, Passes(options)[1]).value();
  const EditableMap whole =
      ToEditable(*RadarMap::FromBytes(BuildMap(map_drive, {.name = "town"}).value()).value());
  const EditableMap before = Thinned(whole);
  // Better, but for the last third, which is half a metre to the side.
  EditableMap after = whole;
  const std::size_t bent_begin = 2 * after.keyframes.size() / 3;
  for (std::size_t k = bent_begin; k < after.keyframes.size(); ++k) {
    for (MapPoint& point : after.keyframes[k].points) point.y_m += 0.5F;
  }
  std::vector<Scan> scans;
  for (const DriveScan& entry : held_out.scans) scans.push_back(entry.scan);
  const auto version = JudgeStreetByStreet(before, after, held_out.rig, scans);
  ASSERT_TRUE(version.ok()) << version.status();
  EXPECT_TRUE(version->evaluation.is_better) << version->evaluation.reason;
  EXPECT_GT(version->left_count, 0U);
  ASSERT_EQ(version->map.keyframes.size(), before.keyframes.size());
  for (std::size_t k = 0; k < before.keyframes.size(); ++k) {
    const bool is_left = version->is_left[version->segments.OfKeyframe(k)];
    EXPECT_TRUE(HasPointsOf(version->map.keyframes[k], (is_left ? before : after).keyframes[k]));
  }
  EXPECT_TRUE(version->is_left[version->segments.OfKeyframe(before.keyframes.size() - 2)]);
  EXPECT_FALSE(version->is_left[version->segments.OfKeyframe(bent_begin / 2)]);
}

}  // namespace
}  // namespace dcloc
