#pragma once

#include "core/geometry/pose.h"
#include "core/radar/ego_velocity.h"
#include "core/radar/radar_model.h"
#include "core/submap/submap.h"

namespace dcloc {

/// Covariance of a registered pose due to the errors that remain in the description of the radars
/// (RadarModel's beta_sigma_s and the like). More points do not reduce it. It is the sum of s^2 J
/// J^T over radars and parameters, J = (sum G^T W G)^-1 sum G^T W d, the first sum over all points
/// and the second over those of the radar, G and d the shifts of a point in the vehicle frame by
/// the pose and by a unit of the parameter, W the point's information. In the tangent space on the
/// right of the pose of the vehicle, whose velocity at the newest scan is `ego_velocity`. Parts
/// name radars of `rig`.
template <int Dim>
TangentMatrix<Dim> CalibrationCovariance(const LiveSubmap<Dim>& live, const Rig& rig,
                                         const EgoVelocity& ego_velocity);

}  // namespace dcloc
