#pragma once

#include <vector>

#include "core/odometry/doppler_ego_velocity.h"
#include "core/radar/static_points.h"
#include "core/registration/registration_workspace.h"
#include "core/submap/submap.h"

namespace dcloc {

/// The memory of each stage of a scan in the plane or in space.
template <int Dim>
struct Workspace {
  EgoVelocityWorkspace ego_velocity;
  std::vector<RadarPoint> static_points;
  std::vector<RadarPoint> tried_points;  // of a scan as another stamp or sign would put them
  Scan fresh_scan;                       // without targets that were sent before
  Scan corrected_scan;                   // with what was learned of its radar
  Scan motionless_scan;                  // without range rates that do not tell the motion
  Scan measured_scan;                    // with the ego-motion in compensated range rates
  Scan rescaled_scan;                    // with a scale that is supposed
  std::vector<GaussianPoint<Dim>> scan_points;
  std::vector<double> rival_fits;
  std::vector<Eigen::Vector2d> range_shifts_m;     // of each of scan_points
  std::vector<GaussianPoint<Dim>> shifted_points;  // scan_points with other ranges
  LiveSubmap<Dim> submap;
  std::vector<GaussianPoint<Dim>> thinned_submap;  // some of its points
  RegistrationWorkspace<Dim> registration;
};

/// Memory that a scan needs only while it is localized. It is lent for one call, to one vehicle at
/// a time: a thousand vehicles on two threads need two of them, and a steady tracker allocates
/// nothing. No answer depends on what is left in it.
struct LocalizerWorkspace {
  Workspace<2> planar;
  Workspace<3> spatial;

  template <int Dim>
  Workspace<Dim>& Of() {
    if constexpr (Dim == 2) {
      return planar;
    } else {
      return spatial;
    }
  }
};

}  // namespace dcloc
