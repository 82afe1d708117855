#pragma once

#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/map/local_map.h"
#include "core/registration/correspondences.h"

namespace dcloc {

/// Memory that registrations need only while they run. No result depends on what is left in it.
template <int Dim>
struct RegistrationWorkspace {
  CorrespondenceFinder<Dim> finder;                ///< after a registration: of its points
  std::vector<GaussianPoint<Dim>> shifted_points;  ///< those that observability is tested with
  CorrespondenceFinder<Dim> shifted_finder;
  typename LocalMap<Dim>::Memory local_map;
};

}  // namespace dcloc
