#include "client/simulation/world/ageing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <tuple>

namespace dcloc::simulation {
namespace {

using Place = std::tuple<double, double, double, double>;

std::multiset<Place> PlacesOf(const World& world) {
  std::multiset<Place> places;
  for (const Scatterer& s : world.scatterers) {
    places.emplace(s.position_m.x(), s.position_m.y(), s.position_m.z(), s.rcs_dbsm);
  }
  return places;
}

int Count(const AgedWorld& aged, const std::string& cause, bool came) {
  return static_cast<int>(std::ranges::count_if(aged.changes, [&](const ScattererChange& change) {
    return change.cause == cause && change.came == came;
  }));
}

const World& Town() {
  static const World* const town = new World(MakeTown(3, 600.0));
  return *town;
}

TEST(AgeingTest, WithoutOptionsNothingChanges) {
  const AgedWorld aged = Age(Town(), {}, 3);
  EXPECT_FALSE(ChangesWorld({}));
  EXPECT_TRUE(aged.changes.empty());
  EXPECT_EQ(PlacesOf(aged.world), PlacesOf(Town()));
}

// What the list of changes says is exactly what the worlds differ by.
TEST(AgeingTest, TheChangesAreTheWholeDifference) {
  const AgeingOptions options{
      .replaced_share = 0.1, .site_m = 60.0, .post_count = 9, .gone_wall_m = 40.0, .leaf_count = 3};
  const AgedWorld aged = Age(Town(), options, 3);
  std::multiset<Place> places = PlacesOf(Town());
  for (const ScattererChange& change : aged.changes) {
    const Scatterer& s = change.scatterer;
    const Place place{s.position_m.x(), s.position_m.y(), s.position_m.z(), s.rcs_dbsm};
    if (change.came) {
      places.insert(place);
      continue;
    }
    const auto found = places.find(place);
    ASSERT_NE(found, places.end());
    places.erase(found);
  }
  EXPECT_EQ(places, PlacesOf(aged.world));
  for (const char* cause : {"replaced", "site", "posts", "leaves"}) {
    EXPECT_GT(Count(aged, cause, true), 0) << cause;
  }
  EXPECT_GT(Count(aged, "gone wall", false), 20);
  EXPECT_EQ(Count(aged, "posts", true), 9);
  EXPECT_LT(aged.world.walls.size(), Town().walls.size() + 6);
}

TEST(AgeingTest, OnARingChangesLieOnTheLap) {
  const AgedWorld aged = Age(MakeTownRing(3, 2500.0, 1000.0),
                             {.site_m = 60.0, .post_count = 9, .gone_wall_m = 60.0}, 3);
  EXPECT_GT(Count(aged, "site", true), 10);
  EXPECT_GT(Count(aged, "gone wall", false), 20);
}

TEST(AgeingTest, AShareIsReplacedNearby) {
  const AgedWorld aged = Age(Town(), {.replaced_share = 0.1}, 3);
  const auto count = static_cast<double>(Town().scatterers.size());
  EXPECT_NEAR(Count(aged, "replaced", false) / count, 0.1, 0.02);
  EXPECT_EQ(Count(aged, "replaced", false), Count(aged, "replaced", true));
  for (std::size_t i = 0; i < aged.changes.size(); i += 2) {
    const double way_m =
        (aged.changes[i].scatterer.position_m - aged.changes[i + 1].scatterer.position_m).norm();
    EXPECT_GE(way_m, 2.0 - 1e-9);
    EXPECT_LE(way_m, 5.0 + 1e-9);
  }
}

TEST(AgeingTest, ALargerShareOnlyTakesMore) {
  std::set<std::uint32_t> few;
  std::set<std::uint32_t> many;
  for (const auto& change : Age(Town(), {.replaced_share = 0.1}, 3).changes) {
    if (!change.came) few.insert(change.scatterer.id);
  }
  for (const auto& change : Age(Town(), {.replaced_share = 0.3}, 3).changes) {
    if (!change.came) many.insert(change.scatterer.id);
  }
  EXPECT_TRUE(std::ranges::includes(many, few));
  EXPECT_GT(many.size(), few.size());
}

TEST(AgeingTest, NewThingsHaveIdsOfTheirOwn) {
  const AgedWorld aged = Age(Town(), {.replaced_share = 0.2, .site_m = 50, .post_count = 9}, 3);
  std::map<std::uint32_t, int> ids;
  for (const Scatterer& scatterer : aged.world.scatterers) ++ids[scatterer.id];
  for (const ScattererChange& change : aged.changes) {
    if (!change.came) continue;
    EXPECT_EQ(ids[change.scatterer.id], 1) << change.cause;
  }
}

TEST(AgeingTest, NothingNewStandsOnTheLanes) {
  const AgedWorld aged = Age(Town(), {.site_m = 60, .post_count = 20}, 3);
  for (const ScattererChange& change : aged.changes) {
    if (!change.came) continue;
    for (double at = 0.0; at < Town().route.length_m(); at += 1.0) {
      const Eigen::Vector2d offset =
          change.scatterer.position_m.head<2>() - Town().route.At(at).position_m;
      EXPECT_GT(offset.norm(), 4.0);
    }
  }
}

}  // namespace
}  // namespace dcloc::simulation
