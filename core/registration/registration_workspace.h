#pragma once

#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/map/local_map.h"
#include "core/registration/correspondences.h"
#include "core/registration/map_fit.h"

namespace dcloc {

/// Memory that registrations need only while they run. No result depends on its former contents.
template <int Dim>
struct RegistrationWorkspace {
  CorrespondenceFinder<Dim> finder;  ///< after a registration it has the registration's points
  std::vector<GaussianPoint<Dim>> observed_points;  ///< with which observability is tested
  MapFit<Dim> map_fit;
  typename LocalMap<Dim>::Workspace local_map;
};

}  // namespace dcloc
