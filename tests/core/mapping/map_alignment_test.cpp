#include "core/mapping/map_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"
#include "core/geometry/degrees.h"
#include "core/map/editable_map.h"
#include "core/map/map_frame.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

/// A map of one of the drives through a town.
std::shared_ptr<const RadarMap> TownMap(std::uint64_t seed, int pass) {
  SimulationOptions options;
  options.seed = seed;
  options.length_m = 500.0;
  options.live_speeds_mps = {15.0};
  const Drive drive =
      SimulatePass(options, Passes(options)[static_cast<std::size_t>(pass)]).value();
  return RadarMap::FromBytes(BuildMap(drive, {.name = "town"}).value()).value();
}

bool ToTheEnd(double /*share*/) { return true; }

TEST(MapAlignmentTest, FindsAMapInOneOfAnotherDriveAndFrame) {
  const auto to = TownMap(5, 0);
  const Pose3 T_to_from = Embed({{-420.0, 910.0}, -2.2});
  const auto moved = MoveTo(ToEditable(*TownMap(5, 1)), T_to_from.Inverse(), std::nullopt);
  const auto from = RadarMap::FromBytes(ToMapBytes(*moved).value()).value();
  const auto alignment = AlignMaps(*from, *to, &ToTheEnd);
  ASSERT_TRUE(alignment.ok()) << alignment.status();
  const Vector6d error = Log(T_to_from.Inverse() * alignment->T_to_from);
  EXPECT_LT(error.head<2>().norm(), 1.5) << "the origin is a kilometre away";
  EXPECT_LT(std::abs(error(5)), 0.1 * kRadPerDeg);
  EXPECT_LT(alignment->rms_m, 0.2);
  EXPECT_GE(alignment->pair_count, 3U);
}

TEST(MapAlignmentTest, ATownThatIsAnotherIsNotFound) {
  const auto alignment = AlignMaps(*TownMap(6, 0), *TownMap(5, 0), &ToTheEnd);
  EXPECT_EQ(alignment.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(alignment.status().message()), HasSubstr("was not found"));
}

TEST(MapAlignmentTest, CanBeEnded) {
  const auto map = TownMap(5, 0);
  const auto alignment = AlignMaps(*map, *map, [](double) { return false; });
  EXPECT_EQ(alignment.status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace dcloc
