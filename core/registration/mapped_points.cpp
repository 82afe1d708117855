#include "core/registration/mapped_points.h"

#include <algorithm>

namespace dcloc {
namespace {

template <int Dim>
bool IsMapped(const Eigen::Vector2f& p_m, const LocalMap<Dim>& map, double reach_m) {
  const auto max_square_m2 = static_cast<float>(reach_m * reach_m);
  bool is_mapped = false;
  map.ForEachRunNear(static_cast<double>(p_m.x()), static_cast<double>(p_m.y()), reach_m,
                     [&](std::size_t begin, std::size_t end) {
                       for (std::size_t i = begin; i < end && !is_mapped; ++i) {
                         const PackedPoint<Dim>& landmark = map.points()[i];
                         const auto e_m = landmark.mean_m.template head<2>() - p_m;
                         is_mapped = e_m.squaredNorm() <= max_square_m2;
                       }
                     });
  return is_mapped;
}

}  // namespace

template <int Dim>
std::size_t CountMappedPoints(std::span<const GaussianPoint<Dim>> points, const LocalMap<Dim>& map,
                              const Pose<Dim>& T_local_vehicle, double reach_m) {
  const Eigen::Matrix<double, Dim, Dim> R = T_local_vehicle.Rotation();
  return static_cast<std::size_t>(
      std::ranges::count_if(points, [&](const GaussianPoint<Dim>& point) {
        const Eigen::Matrix<double, Dim, 1> p_m = R * point.mean_m + T_local_vehicle.translation_m;
        return IsMapped(p_m.template head<2>().template cast<float>(), map, reach_m);
      }));
}

template std::size_t CountMappedPoints<2>(std::span<const GaussianPoint<2>>, const LocalMap<2>&,
                                          const Pose<2>&, double);
template std::size_t CountMappedPoints<3>(std::span<const GaussianPoint<3>>, const LocalMap<3>&,
                                          const Pose<3>&, double);

}  // namespace dcloc
