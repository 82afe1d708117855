#include "core/localizer/health.h"

namespace dcloc {

bool IsTrusted(std::size_t index, Stamp stamp, const LearnedRig& learned_rig,
               const RadarMonitor& radar_monitor) {
  return learned_rig.IsUsable(index, stamp) && radar_monitor.FitsTheMap(index);
}

namespace {

SourceFault FaultOf(const RangeRateError& error) {
  if (error.is_none()) return SourceFault::kNone;
  if (error.is_compensated()) return SourceFault::kStanding;
  if (error.is_offset()) return SourceFault::kBias;
  return error.scale < 0.0 ? SourceFault::kSign : SourceFault::kScale;
}

}  // namespace

Health ReportHealth(Stamp stamp, const EgoMotion& ego_motion, const LearnedRig& learned_rig,
                    const AzimuthSigns& azimuth_signs, const RangeRateErrors& range_rate_errors,
                    const RangeRateOffsets& range_rate_offsets, const RadarMonitor& radar_monitor) {
  Health health{
      .wheel_speed = ego_motion.wheel_speed(), .yaw_rate = ego_motion.yaw_rate(), .radars = {}};
  for (std::size_t i = 0; i < learned_rig.rig().radars.size(); ++i) {
    SourceFault fault = radar_monitor.FaultOf(i, stamp);
    const bool says_something = fault != SourceFault::kSilent && fault != SourceFault::kFrozen &&
                                fault != SourceFault::kDoppler;
    if (fault == SourceFault::kNone) fault = learned_rig.FaultOf(i, stamp);
    if (fault == SourceFault::kNone && azimuth_signs.IsMirrored(i)) fault = SourceFault::kMount;
    if (fault == SourceFault::kNone) fault = FaultOf(range_rate_errors.Whole(i));
    if (fault == SourceFault::kNone && range_rate_offsets.offset_mps(i) != 0.0) {
      fault = SourceFault::kBias;
    }
    health.radars.push_back(
        {.is_used = says_something && IsTrusted(i, stamp, learned_rig, radar_monitor),
         .fault = fault});
  }
  return health;
}

}  // namespace dcloc
