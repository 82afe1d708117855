#include "core/registration/map_fit.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "core/registration/adjugate.h"

namespace dcloc {
namespace {

// The logarithm of a positive normal number, or up to 0.06 less: a chord below the curve from each
// power of two to the next. Costs of landmarks need no more to be compared.
float LogFromBelow(float value) {
  constexpr float kOne = 1065353216.0F;  // the bits of 1.0F, read as a number
  constexpr float kLog2 = std::numbers::ln2_v<float> / 8388608.0F;
  return kLog2 * (static_cast<float>(std::bit_cast<std::int32_t>(value)) - kOne);
}

}  // namespace

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

// That of the landmark with the highest likelihood. Without branches on what a landmark is like:
// they would be guessed wrong too often.
template <int Dim>
float MapFit<Dim>::FitOf(const Turned& point, const Vector& p_m) const {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float max_square_m2 = max_distance_m_ * max_distance_m_;
  float best_cost = kInfinity;
  float best_square = kInfinity;  // of its distance in deviations
  map_->ForEachRunNear(p_m.x(), p_m.y(), max_distance_m_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t index = begin; index < end; ++index) {
      const PackedPoint<Dim>& landmark = map_->points()[index];
      const Vector e_m = landmark.SeenBy(point.slant_per_m) - p_m;
      const Matrix joint_m2 = landmark.template Covariance_m2<float>() + point.covariance_m2;
      const Matrix adjugate = Adjugate<float>(joint_m2);
      const float determinant = joint_m2.row(0).dot(adjugate.col(0).transpose());
      const float square = e_m.dot(adjugate * e_m) / determinant;
      const float cost = square + LogFromBelow(determinant);
      // Written so that what is not a number fails.
      const bool is_better = (determinant > 0.0F) & (square <= gate_) & (cost < best_cost) &
                             (e_m.squaredNorm() <= max_square_m2);
      best_cost = is_better ? cost : best_cost;
      best_square = is_better ? square : best_square;
    }
  });
  return std::exp(-0.5F * best_square);
}

template class MapFit<2>;
template class MapFit<3>;

}  // namespace dcloc
