#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/map/local_map.h"
#include "core/map/radar_map.h"
#include "core/registration/registration_method.h"

namespace dcloc {

/// The registration of points at a place of the map.
template <int Dim>
struct PlaceRegistration {
  Pose3 T_map_vehicle;
  Registration<Dim> registration;
  double work = 0.0;  ///< its cost, see GlobalLocalizerOptions::max_work
};

/// Registers points at places anywhere in the map, each in the local map there. Successive places
/// near the same keyframe share a local map.
template <int Dim>
class PlaceRegistrar {
 public:
  PlaceRegistrar(std::shared_ptr<const RadarMap> map,
                 std::shared_ptr<const RegistrationMethod<Dim>> method, double local_map_radius_m)
      : map_(std::move(map)), method_(std::move(method)), local_map_radius_m_(local_map_radius_m) {}

  /// Registers `points` (vehicle frame) around `T_map_vehicle`, which may be off by
  /// `guess_sigma_m`. Returns nothing if there is no keyframe within reach.
  std::optional<PlaceRegistration<Dim>> Register(std::span<const GaussianPoint<Dim>> points,
                                                 const Pose3& T_map_vehicle, double guess_sigma_m,
                                                 const RegistrationEffort& effort,
                                                 RegistrationWorkspace<Dim>& workspace);

 private:
  std::shared_ptr<const RadarMap> map_;
  std::shared_ptr<const RegistrationMethod<Dim>> method_;
  double local_map_radius_m_;
  LocalMap<Dim> local_map_;
  std::optional<std::size_t> keyframe_;  // of local_map_
};

}  // namespace dcloc
