#include "core/registration/map_fit.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/lanes.h"
#include "core/registration/joint_lanes.h"

namespace dcloc {

template <int Dim>
void MapFit<Dim>::Begin(std::span<const GaussianPoint<Dim>> points, const LocalMap<Dim>& map,
                        const CorrespondenceGates& gates, const Pose<Dim>& T_local_vehicle,
                        double sigma_m) {
  map_ = &map;
  max_distance_m_ = static_cast<float>(gates.max_distance_m);
  gate_ = static_cast<float>(gates.gate_sigmas * gates.gate_sigmas);
  points_.clear();
  const Eigen::Matrix<double, Dim, Dim> R = T_local_vehicle.Rotation();
  for (const GaussianPoint<Dim>& point : points) {
    Eigen::Matrix<double, Dim, Dim> covariance_m2 = R * point.covariance_m2 * R.transpose();
    covariance_m2.diagonal().array() += sigma_m * sigma_m;
    points_.push_back({.p_m = (R * point.mean_m).template cast<float>(),
                       .slant_per_m = (R * point.slant_per_m).template cast<float>(),
                       .covariance_m2 = covariance_m2.template cast<float>()});
  }
}

template <int Dim>
double MapFit<Dim>::At(const Eigen::Matrix<double, Dim, 1>& p_local_m) const {
  if (points_.empty()) return 0.0;
  const Vector vehicle_m = p_local_m.template cast<float>();
  double sum = 0.0;
  for (const Turned& point : points_) sum += FitOf(point, vehicle_m + point.p_m);
  return sum / static_cast<double>(points_.size());
}

// Each of the points that are left adds 0 to 1.
template <int Dim>
bool MapFit<Dim>::IsAtMost(const Eigen::Matrix<double, Dim, 1>& p_local_m, double max_fit) const {
  const Vector vehicle_m = p_local_m.template cast<float>();
  const double max_sum = max_fit * static_cast<double>(points_.size());
  auto left = static_cast<double>(points_.size());
  double sum = 0.0;
  for (const Turned& point : points_) {
    if (sum > max_sum) return false;
    if (sum + left <= max_sum) return true;
    sum += FitOf(point, vehicle_m + point.p_m);
    left -= 1.0;
  }
  return sum <= max_sum;
}

template <int Dim>
double MapFit<Dim>::At(const Eigen::Matrix<double, Dim, 1>& p_local_m, double turn_rad) const {
  if (points_.empty()) return 0.0;
  const Vector vehicle_m = p_local_m.template cast<float>();
  Matrix R = Matrix::Identity();
  R.template topLeftCorner<2, 2>() = Eigen::Rotation2Df(static_cast<float>(turn_rad)).matrix();
  double sum = 0.0;
  for (const Turned& point : points_) {
    const Turned turned{.p_m = R * point.p_m,
                        .slant_per_m = R * point.slant_per_m,
                        .covariance_m2 = R * point.covariance_m2 * R.transpose()};
    sum += FitOf(turned, vehicle_m + turned.p_m);
  }
  return sum / static_cast<double>(points_.size());
}

// That of the landmark with the highest likelihood. Without branches on what a landmark is like:
// they would be guessed wrong too often.
template <int Dim>
float MapFit<Dim>::FitOf(const Turned& point, const Vector& p_m) const {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float max_square_m2 = max_distance_m_ * max_distance_m_;
  Lanes best_costs = InEachLane(kInfinity);
  Lanes best_squares = best_costs;  // of distances in deviations
  map_->ForEachRunNear(p_m.x(), p_m.y(), max_distance_m_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t index = begin; index < end; index += kLaneCount) {
      const PackedLanes<Dim> landmarks = map_->LanesFrom(index);
      const std::array<Lanes, Dim> e_m = landmarks.SeenFrom(p_m, point.slant_per_m);
      const JointLanes<Dim> joint(landmarks, point.covariance_m2);
      const Lanes determinants = joint.Determinant();
      const Lanes squares = joint.ScaledSquare(e_m) / determinants;
      const Lanes costs = squares + LogFromBelow(determinants);
      // Written so that what is not a number fails.
      const LaneMask are_better = FirstLanes(end - index) & (determinants > 0.0F) &
                                  (squares <= gate_) & (costs < best_costs) &
                                  (SquaredNorm(e_m) <= max_square_m2);
      best_costs = are_better ? costs : best_costs;
      best_squares = are_better ? squares : best_squares;
    }
  });
  std::size_t best = 0;
  for (std::size_t lane = 1; lane < kLaneCount; ++lane) {
    if (best_costs[lane] < best_costs[best]) best = lane;
  }
  return std::exp(-0.5F * best_squares[best]);
}

template class MapFit<2>;
template class MapFit<3>;

}  // namespace dcloc
