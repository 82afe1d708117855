#include "client/simulation/motion/traffic.h"
#include "client/simulation/world/steps.h"

#include <cmath>
#include <numbers>

namespace dcloc::simulation {
namespace {

constexpr double kEgoHalfLength = 2.3;   // [m]
constexpr double kEgoMiddleAhead = 1.4;  // of the rear axle [m]

// `value` brought into [0, period).
double Wrap(double value, double period) { return value - period * std::floor(value / period); }

bool TouchesEgo(const MovingBody& body, const Pose2& T_map_ego) {
  const Eigen::Vector2d ego = T_map_ego * Eigen::Vector2d(kEgoMiddleAhead, 0.0);
  const Eigen::Vector2d p_ego =
      Pose2{ego, T_map_ego.yaw_rad}.Inverse() * body.T_map_body.translation_m;
  const double half_length = 0.5 * body.vehicle->length_m + kEgoHalfLength;
  const bool is_parallel = std::abs(std::sin(body.T_map_body.yaw_rad - T_map_ego.yaw_rad)) < 0.3;
  return std::abs(p_ego.x()) < half_length + 0.5 &&
         std::abs(p_ego.y()) < (is_parallel ? 2.2 : half_length);
}

}  // namespace

Traffic::Traffic(const World& world, const EgoMotion& ego, double ego_lane_offset_m,
                 double ego_speed_mps, Random& random)
    : world_(world), ego_(ego), ego_lane_offset_m_(ego_lane_offset_m) {
  for (const Lane& lane : world.lanes) {
    if (lane.offset_m != ego_lane_offset_m) AddLane(lane, ego_speed_mps, random);
  }
  for (const double direction : {1.0, -1.0}) {
    if (!Chance(random, 0.75)) continue;
    Companion companion{MakeVehicle(random, world.truck_share), 0.0, Uniform(random, 2.0, 6.0),
                        Uniform(random, 0.05, 0.2), Uniform(random, 0.0, 2.0 * std::numbers::pi)};
    companion.gap_m = direction * (1.2 * ego_speed_mps + Uniform(random, 12.0, 30.0));
    companions_.push_back(std::move(companion));
  }
  for (const CrossStreet& street : world.cross_streets) AddCrossTraffic(street, random);
}

void Traffic::AddLane(const Lane& lane, double ego_speed_mps, Random& random) {
  const double length_m = world_.route.length_m();
  const double mean_gap_m = 1000.0 / lane.vehicles_per_km;
  // One speed per lane: its vehicles would drive through each other otherwise.
  const double flow_mps =
      lane.direction > 0 ? ego_speed_mps * Uniform(random, 0.8, 1.3) : lane.speed_mps;
  for (const double at : RandomSteps(random, Uniform(random, 0.0, mean_gap_m), length_m,
                                     0.4 * mean_gap_m, 1.6 * mean_gap_m)) {
    lane_vehicles_.push_back({MakeVehicle(random, world_.truck_share),
                              lane.offset_m + Normal(random, 0.0, 0.15), at,
                              lane.direction * flow_mps});
  }
}

void Traffic::AddCrossTraffic(const CrossStreet& street, Random& random) {
  const double length_m = (street.end_m - street.begin_m).norm();
  for (const bool reverse : {false, true}) {
    const CrossStreet way = reverse ? CrossStreet{street.end_m, street.begin_m} : street;
    const double speed_mps = Uniform(random, 7.0, 12.0);
    for (const double at : RandomSteps(random, Uniform(random, 0.0, 60.0), length_m, 30.0, 120.0)) {
      cross_vehicles_.push_back({MakeVehicle(random, world_.truck_share), way, at, speed_mps});
    }
  }
}

MovingBody Traffic::BodyOf(const LaneVehicle& vehicle, double t_s) const {
  const double s = Wrap(vehicle.begin_m + vehicle.speed_mps * t_s, world_.route.length_m());
  MotionState state =
      MotionOnPath(world_.route, s, vehicle.speed_mps, {vehicle.offset_m, 0.0, 0.0});
  // A signed speed along the route's heading; who comes against it points the other way.
  const Eigen::Vector2d velocity = state.speed_mps * Along(state.T_map_vehicle.yaw_rad);
  if (vehicle.speed_mps < 0.0) {
    state.T_map_vehicle.yaw_rad = WrapAngle(state.T_map_vehicle.yaw_rad + std::numbers::pi);
  }
  return {&vehicle.vehicle, state.T_map_vehicle, velocity, state.yaw_rate_radps};
}

MovingBody Traffic::BodyOf(const Companion& companion, double t_s) const {
  const double angle = companion.swing_radps * t_s + companion.phase_rad;
  const double gap = companion.gap_m + companion.gap_swing_m * std::sin(angle);
  const double gap_rate = companion.gap_swing_m * companion.swing_radps * std::cos(angle);
  // Who drives ahead brakes for the same bend earlier.
  const SpeedProfile::State ego = ego_.PathStateAt(t_s + std::copysign(0.5, companion.gap_m));
  const double s = ego.s_m + gap;
  const double speed = ego.speed_mps + gap_rate;
  const double lane_m = -std::abs(ego_lane_offset_m_);  // on the right, whichever way
  const MotionState state = MotionOnPath(ego_.path(), s, speed, {lane_m, 0.0, 0.0});
  return {&companion.vehicle, state.T_map_vehicle,
          state.speed_mps * Along(state.T_map_vehicle.yaw_rad), state.yaw_rate_radps};
}

MovingBody Traffic::BodyOf(const CrossVehicle& vehicle, double t_s) const {
  const Eigen::Vector2d way = vehicle.street.end_m - vehicle.street.begin_m;
  const double heading = std::atan2(way.y(), way.x());
  const double at = Wrap(vehicle.begin_m + vehicle.speed_mps * t_s, way.norm());
  const Eigen::Vector2d position =
      vehicle.street.begin_m + at * Along(heading) - 1.75 * LeftOf(heading);
  return {&vehicle.vehicle, {position, heading}, vehicle.speed_mps * Along(heading), 0.0};
}

std::vector<MovingBody> Traffic::At(double t_s, double radius_m) const {
  const Pose2 T_map_ego = ego_.At(t_s).T_map_vehicle;
  std::vector<MovingBody> bodies;
  const auto add = [&](const MovingBody& body) {
    const double distance = (body.T_map_body.translation_m - T_map_ego.translation_m).norm();
    if (distance < radius_m && !TouchesEgo(body, T_map_ego)) bodies.push_back(body);
  };
  for (const LaneVehicle& vehicle : lane_vehicles_) add(BodyOf(vehicle, t_s));
  for (const Companion& companion : companions_) add(BodyOf(companion, t_s));
  for (const CrossVehicle& vehicle : cross_vehicles_) add(BodyOf(vehicle, t_s));
  return bodies;
}

}  // namespace dcloc::simulation
