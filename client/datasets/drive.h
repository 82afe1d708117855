#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// One scan of a drive with its reference pose.
struct DriveScan {
  /// `scan.ego_velocity` is set where the dataset has wheel or CAN data for its moment.
  Scan scan;
  /// Reference pose at the scan's stamp: to make maps and measure errors, never given to a
  /// localizer.
  Pose3 T_map_vehicle;
};

/// A recorded or simulated drive: its radars and its scans, by ascending stamp.
struct Drive {
  std::string name;
  std::string place;  ///< location name where the dataset has one
  Rig rig;
  std::vector<DriveScan> scans;
};

/// OK when the rig describes the radar of each scan; InvalidArgument names one that it does not.
absl::Status CheckRadarsOfScans(const Drive& drive);

}  // namespace dcloc
