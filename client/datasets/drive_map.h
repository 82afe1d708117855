#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "core/map/map_builder.h"

namespace dcloc {

/// Makes a map of a drive from its scans at its reference poses, in their frame; the bytes are a
/// map file. A scan's ego-velocity is the one that a localizer would use: the drive's, fused with
/// the Doppler estimate. `progress` receives the number of scans done. FailedPrecondition when the
/// drive gave no landmark, InvalidArgument for a scan of a radar that the rig does not describe.
absl::StatusOr<std::vector<std::byte>> BuildMap(
    const Drive& drive, const MapBuilderOptions& options,
    const std::function<void(std::size_t)>& progress = [](std::size_t) {});

}  // namespace dcloc
