#include "core/registration/observability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/geometry/thinning.h"

namespace dcloc {
namespace {

struct Shift {
  double length_m;
  double min_drop;  // of the score, as a fraction of it
};

Eigen::Matrix2d Along(const Observability::Direction& direction, double sigma_m) {
  return sigma_m * sigma_m * direction.axis * direction.axis.transpose();
}

}  // namespace

std::span<const OptionField<ObservabilityOptions>> FieldsOf(
    const ObservabilityOptions& /*options*/) {
  using O = ObservabilityOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_point_count", &O::max_point_count, 10, 100'000},
      {"near_shift_m", &O::near_shift_m, 1e-3, 100},
      {"near_min_drop", &O::near_min_drop, 0, 1, "each direction is observed"},
      {"far_shift_m", &O::far_shift_m, 1e-3, 100},
      {"far_min_drop", &O::far_min_drop, 0, 1, "each direction is observed"},
      {"degenerate_sigma_m", &O::degenerate_sigma_m, 0, 1e6, "all directions weigh the same"},
      {"blunt_shift_m", &O::blunt_shift_m, 1e-3, 100},
      {"blunt_max_drop", &O::blunt_max_drop, 0, 1, "no direction is blunt"},
      {"blunt_sigma_m", &O::blunt_sigma_m, 0, 1e6, "all directions teach the same"},
  };
  return kFields;
}

absl::Status Validate(const ObservabilityOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

bool Observability::Observed(VehicleAxis axis) const {
  const auto i = static_cast<Eigen::Index>(axis);
  return std::ranges::none_of(directions, [&](const Direction& direction) {
    return !direction.observed && std::abs(direction.axis(i)) > 0.5;
  });
}

std::bitset<6> Observability::ObservedDof(bool in_space) const {
  std::bitset<6> observed(in_space ? 0b111100 : 0b100000);
  observed[0] = Observed(VehicleAxis::kX);
  observed[1] = Observed(VehicleAxis::kY);
  return observed;
}

Eigen::Matrix2d Observability::DegeneracyCovariance(double sigma_m) const {
  Eigen::Matrix2d degeneracy = Eigen::Matrix2d::Zero();
  for (const Direction& direction : directions) {
    if (!direction.observed) degeneracy += Along(direction, sigma_m);
  }
  return degeneracy;
}

Eigen::Matrix2d Observability::BluntCovariance(double sigma_m) const {
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Direction& direction : directions) {
    if (direction.blunt) covariance += Along(direction, sigma_m);
  }
  return covariance;
}

template <int Dim>
Observability Observe(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                      const Pose<Dim>& T_local_vehicle, const TangentMatrix<Dim>& covariance,
                      const CorrespondenceGates& gates, const ObservabilityOptions& options,
                      std::vector<GaussianPoint<Dim>>& chosen, MapFit<Dim>& fit) {
  chosen.clear();
  TakeEvenly(live, options.max_point_count,
             [&](const GaussianPoint<Dim>& point) { chosen.push_back(point); });
  constexpr double kSigma_m = 0.0;  // the pose is the one that fits
  fit.Begin(chosen, map, gates, T_local_vehicle, kSigma_m);
  const double here = fit.At(T_local_vehicle.translation_m);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(
      covariance.template topLeftCorner<2, 2>());
  const std::array<Shift, 2> shifts = {
      {{options.near_shift_m, options.near_min_drop}, {options.far_shift_m, options.far_min_drop}}};
  const Eigen::Matrix<double, Dim, Dim> R = T_local_vehicle.Rotation();
  Observability observability;
  if (!(here > 0.0)) return observability;
  for (int i = 0; i < 2; ++i) {
    auto& direction = observability.directions.at(static_cast<std::size_t>(i));
    direction.axis = solver.eigenvectors().col(1 - i);
    const auto is_felt = [&](const Shift& shift) {
      const Eigen::Matrix<double, Dim, 1> aside_m =
          shift.length_m * (R.template leftCols<2>() * direction.axis);
      const auto fits_less_at = [&](const Eigen::Matrix<double, Dim, 1>& p_local_m) {
        return fit.IsAtMost(p_local_m, (1.0 - shift.min_drop) * here);
      };
      return fits_less_at(T_local_vehicle.translation_m + aside_m) &&
             fits_less_at(T_local_vehicle.translation_m - aside_m);
    };
    direction.observed = std::ranges::any_of(shifts, is_felt);
    direction.blunt = !is_felt({options.blunt_shift_m, options.blunt_max_drop});
  }
  return observability;
}

template Observability Observe<2>(std::span<const GaussianPoint<2>>, const LocalMap<2>&,
                                  const Pose2&, const TangentMatrix<2>&, const CorrespondenceGates&,
                                  const ObservabilityOptions&, std::vector<GaussianPoint<2>>&,
                                  MapFit<2>&);
template Observability Observe<3>(std::span<const GaussianPoint<3>>, const LocalMap<3>&,
                                  const Pose3&, const TangentMatrix<3>&, const CorrespondenceGates&,
                                  const ObservabilityOptions&, std::vector<GaussianPoint<3>>&,
                                  MapFit<3>&);

}  // namespace dcloc
