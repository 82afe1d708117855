#pragma once

#include "absl/status/status.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

/// The last step of every reader: applies the request's beta, sorts the scans by stamp and radar,
/// checks that the drive is one that a localizer accepts, and notes a vehicle frame that is tilted
/// where heights are measured. InvalidArgument names a fault.
absl::Status FinishDrive(const DriveRequest& request, Drive& drive);

}  // namespace dcloc
