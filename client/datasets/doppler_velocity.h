#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/radar/ego_velocity.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// The vehicle's velocity where nothing but the radar says how fast it is: the radar's own by the
/// range rates of `scan`, moved to the vehicle's origin by the gyroscope's `turn_rate_radps`, which
/// is in the vehicle frame. It needs no axle without side slip, so that the vehicle's frame may lie
/// anywhere, in the radar too. With covariance. Absent where too few targets agree.
std::optional<EgoVelocity> VelocityByDoppler(const Scan& scan, const RadarModel& radar,
                                             const Eigen::Vector3d& turn_rate_radps);

}  // namespace dcloc
