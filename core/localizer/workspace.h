#pragma once

#include <vector>

#include "core/map/local_map.h"
#include "core/odometry/doppler_ego_velocity.h"
#include "core/radar/static_points.h"
#include "core/registration/correspondences.h"
#include "core/submap/submap.h"

namespace dcloc {

/// What a scan needs only while it is localized. The next one, of whatever vehicle, needs the same
/// again: it belongs to the thread, so that a thousand vehicles on two threads hold two of them and
/// a steady tracker allocates nothing. No answer depends on what is left in it.
template <int Dim>
struct Workspace {
  EgoVelocityMemory ego_velocity;
  std::vector<RadarPoint> static_points;  // of the scan
  LiveSubmap<Dim> submap;
  CorrespondenceFinder<Dim> finder;               // of the last registration
  std::vector<GaussianPoint<Dim>> chosen_points;  // those that are shifted
  CorrespondenceFinder<Dim> chosen_finder;
  typename LocalMap<Dim>::Memory local_map;

  static Workspace& OfThisThread() {
    thread_local Workspace workspace;
    return workspace;
  }
};

}  // namespace dcloc
