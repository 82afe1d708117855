#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
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

/// What the poses of a drive are.
enum class PoseSource {
  kReference,  ///< known in one map frame: good for maps, and to judge answers
  kOdometry,   ///< counted on by the vehicle itself, in a frame of the drive's own, and drifting
  kNone,       ///< not known; they are the identity
};

/// Whose the ego-velocities of a drive are.
enum class VelocitySource {
  kVehicle,  ///< wheels, a gyroscope, or what else the vehicle sends
  kDoppler,  ///< speeds are of the radars' own range rates (doppler_velocity.h)
};

/// A recorded or simulated drive: its radars and its scans, by ascending stamp.
struct Drive {
  std::string name;
  std::string place;  ///< location name where the dataset has one
  Rig rig;
  std::vector<DriveScan> scans;
  PoseSource pose_source = PoseSource::kReference;
  VelocitySource velocity_source = VelocitySource::kVehicle;
  std::vector<std::string> notes;  ///< what the reader has to say of the data, a sentence each
};

/// FailedPrecondition, naming the drive and `purpose`, unless its poses are reference poses.
absl::Status CheckHasReference(const Drive& drive, absl::string_view purpose);

/// OK when the rig describes the radar of each scan; InvalidArgument names one that it does not.
absl::Status CheckRadarsOfScans(const Drive& drive);

}  // namespace dcloc
