#pragma once

#include <string>

#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// `scan` as the bytes of a nuScenes radar sweep: PCD v0.7, binary, the 18 official fields.
///
/// - x, y, z [m] in the radar's frame, as measured (range not compensated); z is 0 without
/// elevation.
/// - vx, vy [m/s] relative to the moving radar: the range rate along the line of sight in the
/// plane,
///   so that (x vx + y vy) / hypot(x, y) is the range rate. vx_comp, vy_comp: the same less what
///   the scan's ego-velocity explains.
/// - *_rms: the ARS408's 5-bit codes of standard deviations. dyn_prop: 1 for what stands still, 0
/// for
///   what moves, by the compensated range rate. Every target is valid and unambiguous.
/// - A scan without targets is one row of NaN, as the devkit expects.
std::string EncodeRadarPcd(const Scan& scan, const RadarModel& radar);

}  // namespace dcloc
