#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/datasets/drive.h"
#include "core/map/radar_map.h"
#include "core/relocalization/initial_pose.h"

namespace dcloc::faults {

/// One scan as it reaches the localizer, and beside it what was really so.
struct StreamScan {
  Scan scan;            ///< as reported: stamp, targets and velocity may lie
  Stamp measured;       ///< when it was really measured
  Stamp arrived;        ///< when it reaches the localizer
  Pose3 T_map_vehicle;  ///< the true pose at `measured`
};

/// What a localizer is given over a drive: the map, the description of the radars, the first pose,
/// the scans in the order in which they arrive.
struct Stream {
  std::string name;
  std::shared_ptr<const RadarMap> map;
  Rig rig;
  InitialPose prior;
  std::vector<StreamScan> scans;
};

/// A window of a drive's true time: from `begin` to before `end`.
struct Window {
  Stamp begin;
  Stamp end = Stamp::max();

  bool Contains(Stamp stamp) const { return stamp >= begin && stamp < end; }
  /// It has no end within a drive.
  bool is_open() const { return end == Stamp::max(); }
};

/// `seconds` as a whole number of nanoseconds.
std::chrono::nanoseconds Duration(double seconds);

/// `drive` as it is: each scan arrives when it is measured and says so. It has no map yet.
Stream StreamOf(const Drive& drive, const InitialPose& prior);

/// Brings the scans into the order of `arrived`; those that arrive together keep their order.
void OrderByArrival(Stream& stream);

/// `drive` driven backwards: the last pose first, the vehicle reversing along its path, at the same
/// times of the clock. Ranges are as range-Doppler coupling shows them then (METHOD eq 5). Every
/// scan is of a radar of the rig.
Drive Reversed(const Drive& drive);

}  // namespace dcloc::faults
