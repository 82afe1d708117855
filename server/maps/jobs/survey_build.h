#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "server/base/framed_file.h"
#include "server/maps/jobs/build_progress.h"
#include "server/maps/jobs/map_build.h"

namespace dcloc::server {

/// Makes a map file's bytes of drives without poses (`SurveyBuilder`), and tells `progress` what
/// became of each drive. `spool` stands behind the header. Errors name the drive and the scan;
/// Cancelled when `progress` is stopped.
absl::StatusOr<std::vector<std::byte>> BuildBySurvey(const BuildRequest& request,
                                                     FramedReader& spool, BuildProgress& progress);

}  // namespace dcloc::server
