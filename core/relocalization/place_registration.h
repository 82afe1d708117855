#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/map/local_map.h"
#include "core/map/radar_map.h"
#include "core/registration/registration_method.h"

namespace dcloc {

/// How points that are registered at a place of the map lie in it.
template <int Dim>
struct PlaceRegistration {
  Pose3 T_map_vehicle;
  Registration<Dim> registration;
  double work = 0.0;  ///< what it took: see GlobalLocalizerOptions::max_work
};

/// Registers points at places all over the map, each in the local map there. Places that follow one
/// another near the same keyframe share it.
template <int Dim>
class PlaceRegistrar {
 public:
  PlaceRegistrar(std::shared_ptr<const RadarMap> map,
                 std::shared_ptr<const RegistrationMethod<Dim>> method, double local_map_radius_m)
      : map_(std::move(map)), method_(std::move(method)), local_map_radius_m_(local_map_radius_m) {}

  /// Registers `points` (vehicle frame) around `T_map_vehicle`, which may be off by
  /// `guess_sigma_m`. Nothing where there is no map.
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
