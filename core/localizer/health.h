#pragma once

#include <cstddef>

#include "absl/container/inlined_vector.h"
#include "core/localizer/radar_monitor.h"
#include "core/odometry/ego_motion.h"
#include "core/odometry/source_fault.h"
#include "core/online_calibration/learned_rig.h"
#include "core/online_calibration/range_rate_errors.h"
#include "core/online_calibration/range_rate_offsets.h"
#include "core/uncertainty/azimuth_signs.h"

namespace dcloc {

/// Which sources take part in an estimate.
struct Health {
  SourceHealth wheel_speed;
  SourceHealth yaw_rate;
  absl::InlinedVector<SourceHealth, 8> radars;  ///< in the rig's order

  friend bool operator==(const Health&, const Health&) = default;
};

/// Whether the targets of radar `index` are put into the sub-map at `stamp`: it looks where its
/// description or the correction of it says, and its targets lie in the map as those of the others
/// do. The pipeline and ReportHealth ask here.
bool IsTrusted(std::size_t index, Stamp stamp, const LearnedRig& learned_rig,
               const RadarMonitor& radar_monitor);

/// What those who watch the sources say at `stamp`. A radar is used if it is trusted and its scans
/// have something to put into the sub-map: it is not silent, and its targets stand still. One of
/// another clock is used, as its stamps are brought to the clock of the others.
Health ReportHealth(Stamp stamp, const EgoMotion& ego_motion, const LearnedRig& learned_rig,
                    const AzimuthSigns& azimuth_signs, const RangeRateErrors& range_rate_errors,
                    const RangeRateOffsets& range_rate_offsets, const RadarMonitor& radar_monitor);

}  // namespace dcloc
