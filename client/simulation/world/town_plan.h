#pragma once

#include <Eigen/Core>
#include <vector>

#include "client/simulation/world/random.h"
#include "client/simulation/world/structures.h"
#include "client/simulation/world/world.h"

namespace dcloc::simulation {

inline constexpr double kStreetHalfWidth = 5.8;  ///< two lanes and two rows of parked cars [m]
inline constexpr double kSidewalk = 2.8;         ///< [m]

/// A street's centreline, at points no more than 2 m apart.
struct Street {
  std::vector<Eigen::Vector2d> points_m;
  double half_width_m = 0.0;
};

/// A crossroads on the route: where its streets meet, and the part of the route that lies in it.
struct Crossroads {
  Eigen::Vector2d centre_m;
  double begin_m = 0.0;
  double end_m = 0.0;
};

/// Where a town's streets run and what ground is still free for houses.
class TownPlan {
 public:
  /// Lays the route, at least `route_length_m` long, and its side streets into `world`; a segment
  /// of `tunnel_m` in the middle of the drive stays straight.
  TownPlan(World& world, double route_length_m, double tunnel_m, Random& random);

  /// The same for a ring of about `lap_m`, on which a drive may go on for ever.
  TownPlan(World& world, double lap_m, Random& random);

  const std::vector<Street>& streets() const { return streets_; }
  const std::vector<Crossroads>& crossroads() const { return crossroads_; }

  /// True when the route is at least `margin_m` (along it) away from any crossroads.
  bool IsAwayFromCrossroads(double s_m, double margin_m) const;

  /// Distance from the nearest edge of a street; negative on it.
  double DistanceFromStreets(const Eigen::Vector2d& position) const;

  /// Takes the ground if no street and no house has it.
  bool Claim(const Footprint& footprint);

 private:
  void AddBlock(World& world, Random& random);
  void AddCrossroads(World& world, Random& random);
  void AddCrossing(World& world, Random& random);
  void AddCorner(World& world, double angle_rad, double radius_m);
  void LayHalfRing(World& world, double length_m, Random& random);
  void AddMainStreet(const World& world);
  void AddSideStreet(World& world, const Eigen::Vector2d& centre, double heading_rad, double back_m,
                     double ahead_m);

  std::vector<Street> streets_;
  std::vector<Crossroads> crossroads_;
  std::vector<Footprint> houses_;
  int quarter_turns_ = 0;
};

}  // namespace dcloc::simulation
