#pragma once

#include <cstdint>
#include <vector>

#include "client/simulation/motion/ego_motion.h"
#include "client/simulation/world/vehicle.h"
#include "client/simulation/world/world.h"

namespace dcloc::simulation {

/// A vehicle at one moment: pose of its middle on the ground and how it moves.
struct MovingBody {
  const Vehicle* vehicle = nullptr;
  Pose2 T_map_body;
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();  ///< in the map
  double yaw_rate_radps = 0.0;
};

/// The other road users of one pass: those in the lanes of the route, one ahead of and one behind
/// the ego vehicle in its own lane, and those on the cross streets. All really move; a body that
/// would touch the ego vehicle is left out (crossing traffic does not wait at lights).
class Traffic {
 public:
  /// `world` and `ego` must outlive it; `ego_lane_offset_m` is left of the world's route, whichever
  /// way the ego vehicle goes. `ego_speed_mps` is what traffic in its direction flows at, more or
  /// less.
  Traffic(const World& world, const EgoMotion& ego, double ego_lane_offset_m, double ego_speed_mps,
          Random& random);

  /// Bodies within `radius_m` of the ego vehicle, in a fixed order.
  std::vector<MovingBody> At(double t_s, double radius_m) const;

 private:
  struct LaneVehicle {
    Vehicle vehicle;
    double offset_m, begin_m, speed_mps;  // speed along the route; negative against it
  };
  struct Companion {
    Vehicle vehicle;
    double gap_m, gap_swing_m, swing_radps, phase_rad;  // gap negative behind
  };
  struct CrossVehicle {
    Vehicle vehicle;
    CrossStreet street;
    double begin_m, speed_mps;
  };

  void AddLane(const Lane& lane, double ego_speed_mps, Random& random);
  void AddCrossTraffic(const CrossStreet& street, Random& random);
  MovingBody BodyOf(const LaneVehicle& vehicle, double t_s) const;
  MovingBody BodyOf(const Companion& companion, double t_s) const;
  MovingBody BodyOf(const CrossVehicle& vehicle, double t_s) const;

  const World& world_;
  const EgoMotion& ego_;
  double ego_lane_offset_m_;
  std::vector<LaneVehicle> lane_vehicles_;
  std::vector<Companion> companions_;
  std::vector<CrossVehicle> cross_vehicles_;
};

}  // namespace dcloc::simulation
