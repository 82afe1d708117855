#include "client/simulation/world/town_plan.h"
#include "client/simulation/world/steps.h"
#include "client/simulation/world/tunnel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace dcloc::simulation {
namespace {

constexpr double kSideStreetLength = 95.0;  // [m]
constexpr double kPointSpacing = 2.0;       // of centrelines and outlines [m]

Eigen::Vector2d Intersection(const Eigen::Vector2d& p, double heading_p, const Eigen::Vector2d& q,
                             double heading_q) {
  Eigen::Matrix2d directions;
  directions << Along(heading_p), -Along(heading_q);
  return p + (directions.inverse() * (q - p)).x() * Along(heading_p);
}

// True when some side of `a` has all of `b` outside it.
bool IsSeparatedBySideOf(const Footprint& a, const Footprint& b) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d side = a[(i + 1) % 4] - a[i];
    const Eigen::Vector2d outward = Eigen::Vector2d(side.y(), -side.x()).normalized();
    const bool all_outside = std::all_of(b.begin(), b.end(), [&](const Eigen::Vector2d& corner) {
      return outward.dot(corner - a[i]) > -0.1;
    });
    if (all_outside) return true;
  }
  return false;
}

bool Overlap(const Footprint& a, const Footprint& b) {
  return !IsSeparatedBySideOf(a, b) && !IsSeparatedBySideOf(b, a);
}

}  // namespace

TownPlan::TownPlan(World& world, double route_length_m, double tunnel_m, Random& random) {
  constexpr double kLongestBlock = 300.0;  // [m]
  world.route.Append(60.0, 0.0);
  while (world.route.length_m() < route_length_m) {
    if (LayTunnelIfNear(world, tunnel_m, kStreetHalfWidth + 0.7, kLongestBlock)) continue;
    AddBlock(world, random);
    AddCrossroads(world, random);
  }
  world.route.Append(kSideStreetLength, 0.0);
  AddMainStreet(world);
}

TownPlan::TownPlan(World& world, double lap_m, Random& random) {
  // A way that turns by half a turn, driven twice, ends where it began: the second half is the
  // first one again, turned. What stands beside it differs.
  Random same_again = random;
  LayHalfRing(world, 0.5 * lap_m, random);
  LayHalfRing(world, 0.5 * lap_m, same_again);
  world.route.Close();
  AddMainStreet(world);
}

// Two sides of a rectangle, about as long as each other, and the corners after them.
void TownPlan::LayHalfRing(World& world, double length_m, Random& random) {
  constexpr double kCornerRadius = 22.0;  // [m]
  const double begin_m = world.route.length_m();
  const double begin_rad = world.route.At(begin_m).heading_rad;
  for (const int side : {1, 2}) {
    AddBlock(world, random);
    while (world.route.length_m() < begin_m + 0.5 * side * length_m - kSideStreetLength) {
      AddCrossing(world, random);
      AddBlock(world, random);
    }
    const double turned_rad = world.route.At(world.route.length_m()).heading_rad - begin_rad;
    AddCorner(world, side * 0.5 * std::numbers::pi - turned_rad, kCornerRadius);
  }
}

void TownPlan::AddMainStreet(const World& world) {
  Street main{{}, kStreetHalfWidth};
  for (const double s : Steps(0.0, world.route.length_m(), kPointSpacing)) {
    main.points_m.push_back(world.route.At(s).position_m);
  }
  streets_.insert(streets_.begin(), std::move(main));
}

void TownPlan::AddBlock(World& world, Random& random) {
  world.route.Append(Uniform(random, 25.0, 60.0), 0.0);
  if (Chance(random, 0.6)) {
    world.route.AppendBend(Uniform(random, -0.22, 0.22), 80.0, 25.0);
  }
  world.route.Append(Uniform(random, 25.0, 80.0), 0.0);
}

void TownPlan::AddSideStreet(World& world, const Eigen::Vector2d& centre, double heading_rad,
                             double back_m, double ahead_m) {
  Street street{{}, kStreetHalfWidth};
  for (const double at : Steps(-back_m, ahead_m + 0.1, kPointSpacing)) {
    street.points_m.push_back(centre + at * Along(heading_rad));
  }
  world.cross_streets.push_back({street.points_m.front(), street.points_m.back()});
  streets_.push_back(std::move(street));
}

void TownPlan::AddCrossroads(World& world, Random& random) {
  if (Chance(random, 0.7)) {
    AddCrossing(world, random);
    return;
  }
  // Turning back to the first heading whenever possible keeps the route from meeting itself.
  const int turn = quarter_turns_ != 0 ? -quarter_turns_ : (Chance(random, 0.5) ? 1 : -1);
  quarter_turns_ += turn;
  const double angle_rad = turn * (0.5 * std::numbers::pi + Uniform(random, -0.12, 0.12));
  AddCorner(world, angle_rad, Uniform(random, 18.0, 28.0));
}

void TownPlan::AddCrossing(World& world, Random& random) {
  const double begin_m = world.route.length_m();
  const PathPoint entry = world.route.At(begin_m);
  world.route.Append(30.0, 0.0);
  const Eigen::Vector2d centre = entry.position_m + 15.0 * Along(entry.heading_rad);
  const double cross_rad = entry.heading_rad + 0.5 * std::numbers::pi + Uniform(random, -0.2, 0.2);
  AddSideStreet(world, centre, cross_rad, kSideStreetLength, kSideStreetLength);
  crossroads_.push_back({centre, begin_m, world.route.length_m()});
  world.stop_lines_m.push_back(begin_m - 4.0);
}

void TownPlan::AddCorner(World& world, double angle_rad, double radius_m) {
  const double begin_m = world.route.length_m();
  const PathPoint entry = world.route.At(begin_m);
  world.route.AppendBend(angle_rad, radius_m, 14.0);
  const PathPoint exit = world.route.At(world.route.length_m());
  const Eigen::Vector2d centre =
      Intersection(entry.position_m, entry.heading_rad, exit.position_m, exit.heading_rad);
  AddSideStreet(world, centre, entry.heading_rad, 0.0, kSideStreetLength);
  AddSideStreet(world, centre, exit.heading_rad, kSideStreetLength, 0.0);
  crossroads_.push_back({centre, begin_m, world.route.length_m()});
  world.stop_lines_m.push_back(begin_m - 4.0);
}

bool TownPlan::IsAwayFromCrossroads(double s_m, double margin_m) const {
  return std::none_of(crossroads_.begin(), crossroads_.end(), [&](const Crossroads& crossroads) {
    return s_m > crossroads.begin_m - margin_m && s_m < crossroads.end_m + margin_m;
  });
}

double TownPlan::DistanceFromStreets(const Eigen::Vector2d& position) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Street& street : streets_) {
    for (const Eigen::Vector2d& point : street.points_m) {
      nearest = std::min(nearest, (point - position).norm() - street.half_width_m);
    }
  }
  return nearest;
}

bool TownPlan::Claim(const Footprint& footprint) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d side = footprint[(i + 1) % 4] - footprint[i];
    const int count = 1 + static_cast<int>(side.norm() / kPointSpacing);
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector2d point = footprint[i] + (static_cast<double>(k) / count) * side;
      if (DistanceFromStreets(point) < kSidewalk - 0.3) return false;
    }
  }
  const bool taken = std::any_of(houses_.begin(), houses_.end(),
                                 [&](const Footprint& house) { return Overlap(house, footprint); });
  if (!taken) houses_.push_back(footprint);
  return !taken;
}

}  // namespace dcloc::simulation
