#pragma once

#include "client/datasets/drive.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// `scan` with the range rates that its targets would have if all of them stood still. A radar that
/// measures no range rates can compensate with these.
Scan WithEgoRangeRates(Scan scan, const RadarModel& radar, const EgoVelocity& ego_velocity);

/// The same for a whole drive, by the ego-motion that its scans give (wheels fused with Doppler).
Drive WithEgoRangeRates(Drive drive);

}  // namespace dcloc
