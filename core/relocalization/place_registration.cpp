#include "core/relocalization/place_registration.h"

#include "core/geometry/pose_estimate.h"

namespace dcloc {

template <int Dim>
std::optional<PlaceRegistration<Dim>> PlaceRegistrar<Dim>::Register(
    std::span<const GaussianPoint<Dim>> points, const Pose3& T_map_vehicle, double guess_sigma_m,
    const RegistrationEffort& effort, RegistrationWorkspace<Dim>& workspace) {
  const std::optional<std::size_t> nearest =
      map_->NearestKeyframe(T_map_vehicle.translation_m, local_map_radius_m_);
  if (!nearest) return std::nullopt;
  if (nearest != keyframe_) {
    local_map_.MoveTo(*map_, T_map_vehicle.translation_m, local_map_radius_m_, workspace.local_map);
    keyframe_ = nearest;
  }
  const Pose3& T_map_local = local_map_.T_map_local();
  const Pose<Dim> guess =
      FromSpace<Dim>(T_map_local.Inverse() * T_map_vehicle, Matrix6d::Zero()).pose;
  const Registration<Dim> registration = method_->Register({.points = points,
                                                            .map = local_map_,
                                                            .T_local_vehicle_guess = guess,
                                                            .guess_sigma_m = guess_sigma_m,
                                                            .effort = effort},
                                                           workspace);
  // Each iteration goes through all points, and the landmarks around each: as much again for every
  // thousand landmarks of the local map.
  constexpr double kLandmarksOfAUnit = 1000.0;
  const double work = static_cast<double>(points.size()) * (1 + registration.iterations) *
                      (1.0 + static_cast<double>(local_map_.points().size()) / kLandmarksOfAUnit);
  return PlaceRegistration<Dim>{
      .T_map_vehicle =
          T_map_local *
          ToSpace<Dim>({.pose = registration.T_local_vehicle}, UnobservedSigmas{}).pose,
      .registration = registration,
      .work = work};
}

template class PlaceRegistrar<2>;
template class PlaceRegistrar<3>;

}  // namespace dcloc
