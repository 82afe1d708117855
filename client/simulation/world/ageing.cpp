#include "client/simulation/world/ageing.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "client/simulation/world/random.h"
#include "client/simulation/world/steps.h"
#include "client/simulation/world/structures.h"
#include "client/simulation/world/town_plan.h"

namespace dcloc::simulation {
namespace {

// Where changes lie, as shares of the drive's length.
constexpr double kSiteAt = 0.2;
constexpr double kGoneWallAt = 0.5;
constexpr double kPostsAt = 0.75;

constexpr double kSiteDepth_m = 3.0;  // from the kerb: the fence and the posts that gave way to it
constexpr double kHouseDepth_m = 25.0;
constexpr double kPostSpacing_m = 4.0;
constexpr double kStep_m = 2.0;        // between points of the route that are compared
constexpr double kTreeExtent_m = 0.2;  // trees are wider than lamps and signs
constexpr double kCrownRadius_m = 1.5;

/// The place of a point beside the route.
struct Beside {
  double at_m = 0.0;    ///< along the route
  double left_m = 0.0;  ///< of it
  double heading_rad = 0.0;
};

class Ager {
 public:
  Ager(const World& world, const AgeingOptions& options, std::uint64_t seed)
      : options_(options), seed_(seed), aged_{.world = world, .changes = {}} {
    for (const double at : Steps(0.0, world.route.length_m(), kStep_m)) {
      route_.emplace_back(at, world.route.At(at));
    }
  }

  AgedWorld Run() && {
    // First what takes, so that what comes is not taken again.
    if (options_.site_m > 0.0) {
      Take("site", {At(kSiteAt), At(kSiteAt) + options_.site_m},
           {-kStreetHalfWidth - kSiteDepth_m, -kStreetHalfWidth});
    }
    if (options_.gone_wall_m > 0.0) {
      Take("gone wall", {At(kGoneWallAt), At(kGoneWallAt) + options_.gone_wall_m},
           {kStreetHalfWidth, kStreetHalfWidth + kHouseDepth_m});
    }
    if (options_.replaced_share > 0.0) Replace();
    if (options_.leaf_count > 0) Add("leaves", 2, [&](Builder& b, Random& r) { AddLeaves(b, r); });
    if (options_.site_m > 0.0) Add("site", 3, [&](Builder& b, Random& r) { AddSite(b, r); });
    if (options_.post_count > 0) Add("posts", 4, [&](Builder& b, Random& r) { AddPosts(b, r); });
    return std::move(aged_);
  }

 private:
  using Range = std::pair<double, double>;

  static bool IsWithin(double value, const Range& range) {
    return value >= range.first && value <= range.second;
  }

  // Of the drive, or of the lap of a ring on which drives go round more than once.
  double At(double share) const {
    const World& world = aged_.world;
    return world.drive_begin_m + share * std::min(world.length_m, world.route.length_m());
  }

  Beside NearestOnRoute(const Eigen::Vector2d& p) const {
    Beside beside;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const auto& [at, point] : route_) {
      const Eigen::Vector2d offset = p - point.position_m;
      if (offset.norm() >= nearest_m) continue;
      nearest_m = offset.norm();
      const Eigen::Vector2d along = Along(point.heading_rad);
      beside = {at + offset.dot(along), offset.dot(LeftOf(point.heading_rad)), point.heading_rad};
    }
    return beside;
  }

  void Take(const std::string& cause, const Range& at_m, const Range& left_m) {
    const auto is_taken = [&](const Eigen::Vector2d& p) {
      const Beside beside = NearestOnRoute(p);
      return IsWithin(beside.at_m, at_m) && IsWithin(beside.left_m, left_m);
    };
    std::erase_if(aged_.world.scatterers, [&](const Scatterer& scatterer) {
      if (!is_taken(scatterer.position_m.head<2>())) return false;
      aged_.changes.push_back({false, cause, scatterer});
      return true;
    });
    std::erase_if(aged_.world.walls,
                  [&](const Wall& wall) { return is_taken(0.5 * (wall.begin_m + wall.end_m)); });
  }

  void Replace() {
    for (Scatterer& scatterer : aged_.world.scatterers) {
      // Each by itself, so that a larger share only takes more.
      Random random = MakeRandom(seed_, Stream::kAgeing, {1, scatterer.id});
      if (!Chance(random, options_.replaced_share)) continue;
      aged_.changes.push_back({false, "replaced", scatterer});
      const bool is_of_wall = scatterer.half_sector_rad < 3.0;
      const double along_rad = is_of_wall
                                   ? scatterer.facing_rad + 0.5 * std::numbers::pi
                                   : NearestOnRoute(scatterer.position_m.head<2>()).heading_rad;
      const double way_m = (Chance(random, 0.5) ? 1.0 : -1.0) * Uniform(random, 2.0, 5.0);
      scatterer.position_m.head<2>() += way_m * Along(along_rad);
      scatterer.id = static_cast<std::uint32_t>(random());
      aged_.changes.push_back({true, "replaced", scatterer});
    }
  }

  // What `build` adds to the world is a change; `purpose` gives it a random stream of its own.
  void Add(const std::string& cause, std::uint64_t purpose,
           const std::function<void(Builder&, Random&)>& build) {
    Random random = MakeRandom(seed_, Stream::kAgeing, {purpose});
    const std::size_t before = aged_.world.scatterers.size();
    Builder builder(aged_.world, random);
    build(builder, random);
    for (std::size_t i = before; i < aged_.world.scatterers.size(); ++i) {
      Scatterer& scatterer = aged_.world.scatterers[i];
      // The builder counts on from what is there, which other changes may have thinned out.
      scatterer.id =
          static_cast<std::uint32_t>(MixBits(MixBits(MixBits(seed_) + purpose) + (i - before)));
      aged_.changes.push_back({true, cause, scatterer});
    }
  }

  void AddLeaves(Builder& builder, Random& random) const {
    const std::vector<Scatterer> trees = aged_.world.scatterers;
    for (const Scatterer& tree : trees) {
      if (tree.extent_m < kTreeExtent_m) continue;
      for (int i = 0; i < options_.leaf_count; ++i) {
        const Eigen::Vector2d leaf =
            tree.position_m.head<2>() + Uniform(random, 0.3, kCrownRadius_m) *
                                            Along(Uniform(random, 0.0, 2.0 * std::numbers::pi));
        builder.AddPole(leaf, Normal(random, -10.0, 3.0), 4.0, Uniform(random, 0.3, 0.8));
      }
    }
  }

  // A fence along the kerb, open to the street, in pieces as the street bends.
  void AddSite(Builder& builder, Random& /*random*/) const {
    const double begin_m = At(kSiteAt);
    const double end_m = begin_m + options_.site_m;
    const auto kerb = [&](double at, double out_m) {
      return OffsetPoint(aged_.world.route, at, -kStreetHalfWidth - out_m);
    };
    for (double at = begin_m; at < end_m; at += 10.0) {
      const double next = std::min(at + 10.0, end_m);
      // Seen from the right of begin -> end, so against the direction of travel.
      builder.AddBarrier(kerb(next, 0.6), kerb(at, 0.6), 2.0, 3.5);
    }
  }

  void AddPosts(Builder& builder, Random& random) const {
    for (int i = 0; i < options_.post_count; ++i) {
      const double at = At(kPostsAt) + kPostSpacing_m * i;
      builder.AddPole(OffsetPoint(aged_.world.route, at, kStreetHalfWidth + 0.4),
                      Normal(random, 4.0, 1.5), 1.0, 0.03);
    }
  }

  const AgeingOptions& options_;
  const std::uint64_t seed_;
  AgedWorld aged_;
  std::vector<std::pair<double, PathPoint>> route_;
};

}  // namespace

bool ChangesWorld(const AgeingOptions& options) {
  return options.replaced_share > 0.0 || options.site_m > 0.0 || options.post_count > 0 ||
         options.gone_wall_m > 0.0 || options.leaf_count > 0;
}

AgedWorld Age(const World& world, const AgeingOptions& options, std::uint64_t seed) {
  if (!ChangesWorld(options)) return {.world = world, .changes = {}};
  return Ager(world, options, seed).Run();
}

}  // namespace dcloc::simulation
