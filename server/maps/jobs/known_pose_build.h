#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "server/base/framed_file.h"
#include "server/maps/jobs/build_progress.h"
#include "server/maps/jobs/map_build.h"

namespace dcloc::server {

/// Makes a map file's bytes of scans at known poses. `spool` stands behind the header. Errors name
/// the scan; Cancelled when `progress` is stopped.
absl::StatusOr<std::vector<std::byte>> BuildAtKnownPoses(const BuildRequest& request,
                                                         FramedReader& spool,
                                                         BuildProgress& progress);

}  // namespace dcloc::server
