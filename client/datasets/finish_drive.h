#pragma once

#include <optional>

#include "absl/status/status.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

/// By how much the way that the vehicle drives leads out of the xy plane of its frame [rad], up
/// positive: the median over its poses, a metre and more apart. It is near 0 for a level frame, and
/// the pitch of its mount for that of a lidar or an IMU. Nothing for a drive of less than 20 m.
///
/// Ego-velocities of wheels and of Doppler lie in that plane. Where heights are estimated too, they
/// drift by this times the way, until a registration contradicts.
std::optional<double> TiltOfWay(const Drive& drive);

/// The last step of every reader: applies the request's beta, sorts the scans by stamp and radar,
/// checks that the drive is one that a localizer accepts, and notes a vehicle frame that is tilted
/// where heights are measured. InvalidArgument names a fault.
absl::Status FinishDrive(const DriveRequest& request, Drive& drive);

}  // namespace dcloc
